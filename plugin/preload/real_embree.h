/// The Embree behind this library.
#pragma once

#include <atomic>

#include "plugin/embree_api.h"
#if RTC_VERSION_MAJOR >= 4
#include "plugin/preload/embree4/later_functions.h"
#endif

namespace stbvh::preload {

/// Those that this library stands in front of, or calls itself.
struct RealEmbree {
#define STBVH_FUNCTION(name) decltype(&::name) name = nullptr;
#include "plugin/preload/real_functions.inl"
#undef STBVH_FUNCTION
};

namespace detail {
inline std::atomic<const RealEmbree*> loaded_embree{nullptr};
const RealEmbree& load_embree();
}  // namespace detail

/// Looks them up at the first call; later it is a load of a pointer, as rays come here. Those that this
/// Embree has not are null, as no program that runs with it calls them; without any Embree in the process it
/// says so and aborts.
inline const RealEmbree& real() {
  const RealEmbree* const loaded = detail::loaded_embree.load(std::memory_order_acquire);
  return loaded != nullptr ? *loaded : detail::load_embree();
}

/// Whether the drop-in library for that major version of Embree is in this process.
bool is_loaded_for(long major);

}  // namespace stbvh::preload
