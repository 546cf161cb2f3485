/// Points in a plane.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "harness/scenes/vec3.h"

namespace stbvh::harness {

using Polygon = std::vector<Vec2>;

/// Twice the area of a triangle, above 0 where it is wound counterclockwise.
inline double doubled_area(Vec2 a, Vec2 b, Vec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// How far points may be from where they belong, as their coordinates were floats: four roundings of the
/// largest.
inline double rounding_of(const Polygon& polygon) {
  double largest = 0;
  for (const Vec2& p : polygon) largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
  return 0x1p-22 * largest;
}

}  // namespace stbvh::harness
