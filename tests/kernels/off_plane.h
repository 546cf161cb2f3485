/// How far a hit lies off the plane of its triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "stbvh/structure.h"

namespace stbvh::test {

/// |n . (o + t d - p)| of the triangle between `from` and `to` at `fraction`, as a share of what rounding may
/// make of it: 16 roundings of each coordinate of vertices and origin, and of what the direction covers on
/// its way to the hit; where the plane is met beyond the triangle's bounds, on its way to the corners
/// (docs/accuracy.md). In double; never above 1.
inline double off_plane(const std::array<Vec3f, 3>& from, const std::array<Vec3f, 3>& to, float fraction,
                        const Ray& ray, float t) {
  constexpr double kRounding = 0x1p-20;
  constexpr double kLeast = std::numeric_limits<float>::min();  // what flush-to-zero may take away
  const double f = fraction;
  const double o[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
  const double d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  double q[3][3], size[3] = {};  // axis by axis: corners as seen from the origin, what made the largest
  double reach = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double a[3] = {from[c].x, from[c].y, from[c].z}, b[3] = {to[c].x, to[c].y, to[c].z};
    for (std::size_t k = 0; k < 3; ++k) {
      q[k][c] = (1 - f) * (a[k] - o[k]) + f * (b[k] - o[k]);
      size[k] = std::max({size[k], std::fabs(a[k]) + std::fabs(o[k]), std::fabs(b[k]) + std::fabs(o[k])});
      reach = std::max(reach, std::fabs(q[k][c]));
    }
  }
  double normal[3], distance = 0, facing = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    normal[k] = (q[i][1] - q[i][0]) * (q[j][2] - q[j][0]) - (q[j][1] - q[j][0]) * (q[i][2] - q[i][0]);
    distance += normal[k] * q[k][0];
    facing += normal[k] * d[k];
  }
  const double largest = std::max({std::fabs(d[0]), std::fabs(d[1]), std::fabs(d[2])});
  bool is_within = true;  // false as well where there is no such point
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [lower, upper] = std::minmax_element(q[k], q[k] + 3);
    // What decides along the largest axis are floats; elsewhere doubles.
    const double slack = std::fabs(d[k]) == largest ? kRounding * size[k] : -0x1p-40 * reach;
    const double at = distance / facing * d[k];
    is_within = is_within && (d[k] == 0 || (at >= *lower + slack && at <= *upper - slack));
  }
  const double way = is_within ? std::fabs(t) : reach / largest;
  const double off = std::fabs(t * facing - distance);
  double allowed = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    allowed += std::fabs(normal[k]) *
               (kRounding * (size[k] + way * std::fabs(d[k])) + kLeast * (4 + std::fabs(d[k])));
  }
  return off == 0 ? 0 : off / allowed;
}

}  // namespace stbvh::test
