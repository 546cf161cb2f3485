#include "layout/node_slots.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace stbvh {

namespace {

template <typename Node>
constexpr bool kMoves = requires(Node node) {
  node.slopes;
};
template <typename Node>
constexpr bool kHasTimes = requires(Node node) {
  node.time_last;
};

template <typename Node>
NodeSlots read_as(const std::byte* data, const ClosedTimeRange& range) {
  Node node;
  std::memcpy(&node, data, sizeof node);
  NodeSlots result;
  result.range = range;
  for (std::size_t i = 0; i < kWidth; ++i) {
    if (!(node.planes[kLowerX][i] <= node.planes[kUpperX][i])) continue;  // empty
    NodeSlot& slot = result.slots[result.count++];
    slot.link = node.children[i];
    slot.range = range;
    if constexpr (kHasTimes<Node>) slot.range = {node.time_begin[i], node.time_last[i]};
    for (std::size_t plane = 0; plane < kPlanes; ++plane) {
      slot.planes[plane] = node.planes[plane][i];
      slot.slopes[plane] = 0.0f;
      if constexpr (kMoves<Node>) slot.slopes[plane] = node.slopes[plane][i];
    }
  }
  return result;
}

template <typename Node>
void write_as(const NodeSlots& slots, std::byte* out) {
  Node node{};
  constexpr float inf = std::numeric_limits<float>::infinity();
  for (std::size_t plane = 0; plane < kPlanes; ++plane)
    std::fill_n(node.planes[plane], kWidth, plane < kUpperX ? inf : -inf);
  for (std::size_t i = 0; i < slots.count; ++i) {
    const NodeSlot& slot = slots.slots[i];
    node.children[i] = slot.link;
    for (std::size_t plane = 0; plane < kPlanes; ++plane) {
      node.planes[plane][i] = slot.planes[plane];
      if constexpr (kMoves<Node>) node.slopes[plane][i] = slot.slopes[plane];
    }
    if constexpr (kHasTimes<Node>) {
      node.time_begin[i] = slot.range.begin;
      node.time_last[i] = slot.range.last;
    }
  }
  if constexpr (kMoves<Node> && !kHasTimes<Node>) node.time_begin = slots.range.begin;
  std::memcpy(out, &node, sizeof node);
}

}  // namespace

LinearBounds NodeSlot::bounds() const {
  const auto box = [this](double elapsed) {
    float faces[kPlanes];
    for (std::size_t plane = 0; plane < kPlanes; ++plane) {
      faces[plane] = planes[plane];
      if (slopes[plane] == 0.0f) continue;
      const double exact = planes[plane] + elapsed * slopes[plane];
      faces[plane] = static_cast<float>(exact);
      const bool is_lower = plane < kUpperX;
      if (is_lower ? faces[plane] > exact : faces[plane] < exact) {
        const float outwards = std::numeric_limits<float>::infinity();
        faces[plane] = std::nextafter(faces[plane], is_lower ? -outwards : outwards);
      }
    }
    return Box4{F32x4(faces[kLowerX], faces[kLowerY], faces[kLowerZ]),
                F32x4(faces[kUpperX], faces[kUpperY], faces[kUpperZ])};
  };
  if (is_static()) return {box(0.0), box(0.0)};
  return {box(0.0), box(static_cast<double>(range.last) - range.begin)};
}

bool NodeSlot::is_static() const {
  return std::all_of(slopes.begin(), slopes.end(), [](float slope) { return slope == 0.0f; });
}

NodeSlot make_slot(const NodePlan::Child& child) {
  NodeSlot slot;
  slot.link = child.link;
  slot.range = child.range;
  const auto& [begin, end] = child.bounds;
  for (int axis = 0; axis < 3; ++axis) {
    const float duration = child.range.length();
    const Face lower = make_face(begin.lower[axis], end.lower[axis], duration, false);
    const Face upper = make_face(begin.upper[axis], end.upper[axis], duration, true);
    const auto place = static_cast<std::size_t>(axis);
    slot.planes[kLowerX + place] = lower.plane;
    slot.slopes[kLowerX + place] = lower.slope;
    slot.planes[kUpperX + place] = upper.plane;
    slot.slopes[kUpperX + place] = upper.slope;
  }
  return slot;
}

LinkKind NodeSlots::kind() const {
  bool moves = false;
  for (const NodeSlot& slot : used()) {
    if (!(slot.range == range)) return LinkKind::kSpatialTemporalNode;
    moves = moves || !slot.is_static();
  }
  return moves ? LinkKind::kLinearNode : LinkKind::kStaticNode;
}

NodeSlots read_node(LinkKind kind, const std::byte* data, const ClosedTimeRange& range) {
  switch (kind) {
    case LinkKind::kStaticNode:
      return read_as<StaticNode>(data, range);
    case LinkKind::kLinearNode:
      return read_as<LinearNode>(data, range);
    default:
      return read_as<SpatialTemporalNode>(data, range);
  }
}

namespace {

void write(LinkKind kind, const NodeSlots& node, std::byte* out) {
  switch (kind) {
    case LinkKind::kStaticNode:
      return write_as<StaticNode>(node, out);
    case LinkKind::kLinearNode:
      return write_as<LinearNode>(node, out);
    default:
      return write_as<SpatialTemporalNode>(node, out);
  }
}

}  // namespace

void write_node(const NodeSlots& node, std::byte* out) {
  write(node.kind(), node, out);
}

void write_node(const NodePlan& plan, std::byte* out) {
  NodeSlots node;
  node.range = plan.range;
  for (const NodePlan::Child& child : std::span(plan.children).first(plan.count))
    node.slots[node.count++] = make_slot(child);
  write(plan.kind(), node, out);
}

}  // namespace stbvh
