/// The Embree behind this library.
#pragma once

#include <embree3/rtcore.h>

namespace stbvh::preload {

/// Those that this library stands in front of, or calls itself.
struct RealEmbree {
#define STBVH_FUNCTION(name) decltype(&::name) name = nullptr;
#include "plugin/preload/real_functions.inl"
#undef STBVH_FUNCTION
};

/// Looks them up at the first call; without an Embree 3 in the process it says so and aborts.
const RealEmbree& real();

}  // namespace stbvh::preload
