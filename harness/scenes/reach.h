/// How far from the origin things may be.
#pragma once

#include <algorithm>
#include <cmath>

#include "harness/scenes/vec3.h"
#include "stbvh/mesh_view.h"

namespace stbvh::harness {

/// The last float below kMaxCoordinate.
inline constexpr double kFarthest = double{kMaxCoordinate} - 0x1p37;
static_assert(kFarthest == static_cast<double>(static_cast<float>(kFarthest)));

/// Whether a coordinate or a length is finite and, as a float, below kMaxCoordinate, as vertices must be.
/// Embree aborts the process on rays from further away.
inline bool is_within_reach(double x) {
  return std::abs(x) <= kFarthest;
}
inline bool is_within_reach(Vec3 p) {
  return is_within_reach(p.x) && is_within_reach(p.y) && is_within_reach(p.z);
}
/// How much of the way from `from`, which is within reach, is so too; all: 1.
inline double share_within_reach(Vec3 from, Vec3 way) {
  const auto share = [](double at, double by) {
    return by == 0 ? 1 : (std::copysign(kFarthest, by) - at) / by;
  };
  return std::min({1.0, share(from.x, way.x), share(from.y, way.y), share(from.z, way.z)});
}

}  // namespace stbvh::harness
