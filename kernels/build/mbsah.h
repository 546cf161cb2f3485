/// The cost model: the motion blur surface area heuristic (Woop et al. 2017, section 3.3) with the leaves
/// that this implementation really has.
///
/// The paper's C_leaf counts primitive *segments*. A leaf here holds up to eight triangles over all segments
/// of its time range and costs the same however many those are, so C_leaf counts leaves; a temporal split
/// then pays only where it shrinks boxes.
#pragma once

#include <cmath>
#include <cstddef>

#include "build/linear_bounds.h"
#include "build/mesh_set.h"

namespace stbvh {

/// Cost of testing one leaf and of testing the eight boxes of one node, in the collapse. A node cost of 2
/// gives the same trees (docs/performance.md).
inline constexpr float kLeafCost = 1.0f;
inline constexpr float kNodeCost = 1.0f;

/// Triangles that a full leaf holds on connected meshes: eight vertices of a triangle strip hold six.
inline constexpr float kTrianglesPerLeaf = 6.0f;

/// Cost of splitting a set that one leaf could hold: a share of the node that will hold the two children.
/// 0.5 visits as much and saves 1 % of the bytes (docs/performance.md).
inline constexpr float kSplitCost = 0.25f;

/// A leaf is worth a temporal split where that leaves less than this share of its expected area.
inline constexpr float kTemporalWorth = 0.75f;

/// A set is split in time before it is split in space where at least this share of its leaves is worth it.
inline constexpr float kTemporalShare = 0.75f;

/// Extent of a leaf, in extents of its triangles: sqrt(5) on a surface. 3 visits 1 % more
/// (docs/performance.md).
inline constexpr float kLeafExtent = 2.2f;

/// Leaves needed for `references`, the unit of C_leaf.
inline float leaf_count(std::size_t references) {
  return std::ceil(static_cast<float>(references) / kTrianglesPerLeaf);
}

/// Share of `whole` that `part` takes in time.
inline float time_share(const ClosedTimeRange& part, const ClosedTimeRange& whole) {
  const float length = whole.last - whole.begin;
  return length > 0.0f ? (part.last - part.begin) / length : 1.0f;
}

/// SA'(bounds) * T(range): proportional to the probability that a random ray meets them.
inline float expected_area(const LinearBounds& bounds, const ClosedTimeRange& range) {
  return bounds.centre_area() * (range.last - range.begin);
}

}  // namespace stbvh
