/// Polygons as triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// A polygon that has more than one meaning.
struct PolygonFlaws {
  bool is_bent = false;         ///< its corners are off its plane by more than a hundredth of its size
  bool crosses_itself = false;  ///< seen along its normal
};

/// Appends the triangles of a polygon of 3 or more corners to `triangles`: three of its corners' numbers for
/// each, two fewer than there are corners, wound as it is. As seen along its normal they cover it once,
/// unless it crosses itself: a fan about its first corner where that does, else ears are clipped (Meisters
/// 1975). Holes may be joined to the outline by an edge in both directions; where it folds back onto itself
/// there are triangles without area. Takes near linear time. Where a corner is not finite the shape is not
/// known: all triangles have that corner.
PolygonFlaws cut_polygon(std::span<const Vec3> corners, std::vector<std::uint32_t>& triangles);

}  // namespace stbvh::harness
