/// A node taken apart and put together again: its children as they stand in its bytes.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "layout/closed_time_range.h"
#include "layout/layout.h"
#include "layout/linear_bounds.h"
#include "layout/node_plan.h"

namespace stbvh {

/// A child with its faces b(t) = planes + (t - range.begin) * slopes, as the node holds them: put together
/// again they are the same bits.
struct NodeSlot {
  std::array<float, kPlanes> planes;
  std::array<float, kPlanes> slopes;
  Link link;
  ClosedTimeRange range;

  /// Linear bounds over `range` that hold what the faces hold.
  LinearBounds bounds() const;
  bool is_static() const;
};

/// The faces of a child whose bounds are known, rounded outwards.
NodeSlot make_slot(const NodePlan::Child& child);

struct NodeSlots {
  ClosedTimeRange range;
  std::array<NodeSlot, kWidth> slots;
  std::size_t count = 0;

  std::span<NodeSlot> used() { return {slots.data(), count}; }
  std::span<const NodeSlot> used() const { return {slots.data(), count}; }
  /// The smallest kind of node that holds these children.
  LinkKind kind() const;
};

/// The children of the node at `data`, which is alive in `range`.
NodeSlots read_node(LinkKind kind, const std::byte* data, const ClosedTimeRange& range);

/// Writes a node of the kind node.kind().
void write_node(const NodeSlots& node, std::byte* out);
/// Writes a node of the kind plan.kind(), its bounds anchored and rounded outwards.
void write_node(const NodePlan& plan, std::byte* out);

inline LinkKind kind_of(Link link) {
  return static_cast<LinkKind>(link >> kLinkKindShift);
}
inline std::size_t unit_of(Link link) {
  return link & kLinkOffsetMask;
}
inline Link make_link(LinkKind kind, std::size_t unit) {
  return static_cast<Link>(unit) | (static_cast<Link>(kind) << kLinkKindShift);
}

}  // namespace stbvh
