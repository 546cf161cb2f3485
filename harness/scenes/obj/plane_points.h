/// Points in a plane.
#pragma once

#include <vector>

#include "harness/scenes/vec3.h"

namespace stbvh::harness {

using Polygon = std::vector<Vec2>;

/// Twice the area of a triangle, above 0 where it is wound counterclockwise.
inline double doubled_area(Vec2 a, Vec2 b, Vec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}  // namespace stbvh::harness
