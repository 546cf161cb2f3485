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
/// 1975). Holes may be joined to the outline by an edge in both directions. Takes near linear time. Corners
/// that are not finite are taken for a fan.
PolygonFlaws cut_polygon(std::span<const Vec3> corners, std::vector<std::uint32_t>& triangles);

}  // namespace stbvh::harness
