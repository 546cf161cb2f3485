/// A ray as bounds in other directions than the axes meet it.
#pragma once

#include <algorithm>
#include <cmath>

#include "traverse/ray_setup.inl"

namespace stbvh::harness::gallery {
namespace {

/// Directions below this meet slabs as if they were as large: the inverse stays finite (ray_setup.inl).
constexpr float kLeastDirection = 1e-18f;

/// Relative to a point among the geometry, so that what rounds is as small as the distance to the scene, not
/// as large as coordinates. With u = 2^-24 each coordinate of the origin is off by u * distance, each
/// component of the direction, of which the largest is 1, by u.
struct CentredRay {
  float origin[3];
  float direction[3];
  float distance;  ///< largest along an axis, from the origin to anything in the scene, and to the centre

  CentredRay(const StructureView& structure, const TraversalRay& ray, const float (&centre)[3])
      : distance(_mm_cvtss_f32(largest_distance(structure, _mm_load_ps(ray.origin)))) {
    for (int i = 0; i < 3; ++i) {
      origin[i] = ray.origin[i] - centre[i];
      direction[i] = ray.direction[i] / ray.s_scale;
      distance = std::max(distance, std::fabs(origin[i]));
    }
  }
};

}  // namespace
}  // namespace stbvh::harness::gallery
