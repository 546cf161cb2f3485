/// Lights from far away, out of a disc.
#pragma once

#include <cmath>
#include <numbers>

#include "stbvh/vec.h"

namespace stbvh::harness::embree_xml {

/// Irradiance over radiance of a disc of directions, on a surface that faces its centre.
inline double projected_solid_angle(float half_angle_degrees) {
  const double sine = std::sin(static_cast<double>(half_angle_degrees) * std::numbers::pi / 180);
  return std::numbers::pi * sine * sine;
}

inline Vec3f scaled(Vec3f color, double factor) {
  const auto channel = [&](float x) { return static_cast<float>(factor * static_cast<double>(x)); };
  return {channel(color.x), channel(color.y), channel(color.z)};
}

}  // namespace stbvh::harness::embree_xml
