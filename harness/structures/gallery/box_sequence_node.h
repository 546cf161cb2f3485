/// A node that holds a sequence of boxes of each child, one at each step of the node's own time grid. It
/// includes little: sources for one instruction set include it.
#pragma once

#include <cstdint>

#include "layout/layout.h"

namespace stbvh::harness::gallery {

struct alignas(kUnitBytes) StepBoxes {
  float planes[kPlanes][kWidth];
};

/// The StepBoxes of `segments` + 1 steps follow in memory.
struct alignas(kUnitBytes) BoxSequenceNode {
  Link children[kWidth];
  float time_begin;         ///< of the first step
  float segments_per_time;  ///< steps are equidistant
  std::uint32_t segments;   ///< 0: one box for all times
  std::uint32_t unused[5];  ///< 0
};
static_assert(sizeof(BoxSequenceNode) == 64 && sizeof(StepBoxes) == 192);

/// Planes of empty slots: hit by no ray, as with infinite ones, of which 0 times one would be no number.
inline constexpr float kEmptyPlane = 0x1p127f;

static inline const StepBoxes* steps_of(const BoxSequenceNode& node) {
  return reinterpret_cast<const StepBoxes*>(&node + 1);
}

/// The segment of a node with more than one step. A time outside the grid counts as the nearest one inside.
static inline SegmentTime segment_at(const BoxSequenceNode& node, float time) {
  const auto end = static_cast<float>(node.segments);
  float u = (time - node.time_begin) * node.segments_per_time;
  u = u > 0.0f ? u : 0.0f;
  u = u < end ? u : end;
  const auto truncated = static_cast<std::uint32_t>(static_cast<int>(u));
  const std::uint32_t segment = truncated < node.segments ? truncated : node.segments - 1;
  return {segment, u - static_cast<float>(static_cast<int>(segment))};
}

}  // namespace stbvh::harness::gallery
