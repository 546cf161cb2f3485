/// The cost model: the motion blur surface area heuristic (Woop et al. 2017, section 3.3) with the leaves
/// that this implementation really has.
///
/// The paper's C_leaf counts primitive *segments*. A leaf here holds up to eight triangles over all segments
/// of its time range and costs the same however many those are, so C_leaf counts leaves (a reference is one);
/// a temporal split then pays only where it shrinks boxes.
#pragma once

#include "layout/closed_time_range.h"
#include "layout/linear_bounds.h"

namespace stbvh {

/// Cost of testing one leaf and of testing the eight boxes of one node, in the collapse. A node cost of 2
/// gives the same trees (docs/performance.md).
inline constexpr float kLeafCost = 1.0f;
inline constexpr float kNodeCost = 1.0f;

/// Triangles share a meshlet unless two leaves would be cheaper even with this share of the node that holds
/// them: less makes more and smaller leaves (docs/performance.md).
inline constexpr float kSplitCost = 0.1f;

/// Cost of testing an indexed leaf, whose vertices are waited for.
inline constexpr float kIndexedLeafCost = 3.5f;

/// How much memory may bring too little: a hundredth more bytes must save this many hundredths of the leaves'
/// expected area.
inline constexpr float kElasticity = 0.7f;

/// However cheap memory is, a leaf is worth a temporal split only where that leaves less than this share of
/// its expected area.
inline constexpr float kLeastShrinking = 0.97f;

/// A set is split in time before it is split in space where at least this share of its leaves is worth it.
inline constexpr float kTemporalShare = 0.75f;

/// What a vertex slot of a meshlet is worth, in shares of its area: an eighth of a leaf.
inline constexpr float kVertexWeight = 0.125f;
/// A triangle that its neighbours have left alone will cost a leaf of its own: it joins a meshlet the sooner,
/// by this share of its area, the fewer of them remain.
inline constexpr float kOrphanWeight = 0.5f;

/// SA'(bounds) * T(range): proportional to the probability that a random ray meets them.
inline float expected_area(const LinearBounds& bounds, const ClosedTimeRange& range) {
  return bounds.centre_area() * range.length();
}

}  // namespace stbvh
