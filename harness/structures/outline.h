/// What a node bounds its subtree with, for pictures.
#pragma once

#include <vector>

#include "stbvh/vec.h"

namespace stbvh::harness {

/// Corners of a convex body, in no order.
using Outline = std::vector<Vec3f>;

/// The eight corners of a box.
inline Outline corners_of(const Box3f& box) {
  Outline corners;
  for (const float x : {box.lower.x, box.upper.x}) {
    for (const float y : {box.lower.y, box.upper.y}) {
      for (const float z : {box.lower.z, box.upper.z}) corners.push_back({x, y, z});
    }
  }
  return corners;
}

}  // namespace stbvh::harness
