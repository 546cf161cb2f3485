/// How far from the origin things may be.
#pragma once

#include <cmath>

#include "harness/scenes/vec3.h"
#include "stbvh/mesh_view.h"

namespace stbvh::harness {

/// Whether a coordinate or a length is finite and below kMaxCoordinate, as vertices must be. Embree aborts
/// the process on rays from further away.
inline bool is_within_reach(double x) {
  return std::abs(x) < double{kMaxCoordinate};
}
inline bool is_within_reach(Vec3 p) {
  return is_within_reach(p.x) && is_within_reach(p.y) && is_within_reach(p.z);
}

}  // namespace stbvh::harness
