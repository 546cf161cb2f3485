/// Local frames, and directions drawn with known densities from points of the unit square.
#pragma once

#include <algorithm>
#include <cmath>

#include "harness/path_tracer/sobol_sampler.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// An orthonormal basis whose z axis is the unit vector `z`.
struct Frame {
  Vec3 x, y, z;

  explicit Frame(Vec3 axis) : x(perpendicular(axis)), y(cross(axis, x)), z(axis) {}
  Vec3 to_local(Vec3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  Vec3 to_world(Vec3 v) const { return v.x * x + v.y * y + v.z * z; }
};

/// Uniform in the unit disc, without tearing neighbours apart (Shirley and Chiu 1997).
inline Vec3 disc_point(SamplePoint s) {
  const double a = 2 * s.x - 1, b = 2 * s.y - 1;
  if (a == 0 && b == 0) return {};
  const bool along_a = std::abs(a) > std::abs(b);
  const double radius = along_a ? a : b;
  const double angle = along_a ? kPi / 4 * (b / a) : kPi / 2 - kPi / 4 * (a / b);
  return {radius * std::cos(angle), radius * std::sin(angle), 0};
}

/// Around the z axis with density cosine / pi.
inline Vec3 cosine_direction(SamplePoint s) {
  const Vec3 d = disc_point(s);
  return {d.x, d.y, std::sqrt(std::max(0.0, 1 - d.x * d.x - d.y * d.y))};
}

/// Uniform in the cone around the z axis whose directions have at least `least_cosine`.
inline Vec3 cone_direction(SamplePoint s, double least_cosine) {
  const double rise = s.x * (1 - least_cosine);  // 1 - cosine, without cancellation in narrow cones
  const double radius = std::sqrt(std::max(0.0, rise * (2 - rise)));
  const double angle = 2 * kPi * s.y;
  return {radius * std::cos(angle), radius * std::sin(angle), 1 - rise};
}

}  // namespace stbvh::harness
