/// The Embree behind this library.
#pragma once

#include "plugin/embree_api.h"
#if RTC_VERSION_MAJOR >= 4
#include "plugin/preload/embree4/later_functions.h"
#endif

namespace stbvh::preload {

/// Those that this library stands in front of, or calls itself.
struct RealEmbree {
#define STBVH_FUNCTION(name) decltype(&::name) name = nullptr;
#include "plugin/preload/real_functions.inl"
#if RTC_VERSION_MAJOR >= 4
#include "plugin/preload/embree4/real_functions.inl"
#endif
#undef STBVH_FUNCTION
};

/// Looks them up at the first call. Those that this Embree has not are null, as no program that runs with it
/// calls them; without any Embree in the process it says so and aborts.
const RealEmbree& real();

/// Whether the drop-in library for that major version of Embree is in this process.
bool is_loaded_for(long major);

}  // namespace stbvh::preload
