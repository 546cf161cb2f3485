#include "layout/node_plan.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

namespace stbvh {

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

void write_planes(const LinearBounds& bounds, float duration, std::size_t slot, float (*planes)[kWidth],
                  float (*slopes)[kWidth]) {
  const auto& [begin, end] = bounds;
  for (int upper = 0; upper < 2; ++upper) {
    const F32x4 at_begin = upper ? begin.upper : begin.lower, at_last = upper ? end.upper : end.lower;
    for (int axis = 0; axis < 3; ++axis) {
      const Face face = make_face(at_begin[axis], at_last[axis], duration, upper != 0);
      planes[upper * 3 + axis][slot] = face.plane;
      if (slopes != nullptr) slopes[upper * 3 + axis][slot] = face.slope;
    }
  }
}

void clear_planes(float (*planes)[kWidth]) {
  for (int plane = 0; plane < kPlanes; ++plane) {
    std::fill_n(planes[plane], kWidth, plane < kUpperX ? kInf : -kInf);
  }
}

template <typename Node>
void write_as(const NodePlan& plan, std::byte* out) {
  Node node{};
  clear_planes(node.planes);
  for (std::size_t i = 0; i < plan.count; ++i) {
    const auto& [bounds, range, link] = plan.children[i];
    node.children[i] = link;
    if constexpr (requires { node.time_last; }) {
      node.time_begin[i] = range.begin;
      node.time_last[i] = range.last;
    }
    if constexpr (requires { node.slopes; }) {
      write_planes(bounds, range.length(), i, node.planes, node.slopes);
    } else {
      write_planes(bounds, 0.0f, i, node.planes, nullptr);
    }
  }
  if constexpr (std::is_same_v<Node, LinearNode>) node.time_begin = plan.range.begin;
  std::memcpy(out, &node, sizeof node);
}

}  // namespace

Face make_face(float at_begin, float at_last, float duration, bool upper) {
  const float outwards = upper ? kInf : -kInf;
  if (at_begin == at_last) return {at_begin, 0.0f};
  if (!(duration > 0.0f)) return {upper ? std::max(at_begin, at_last) : std::min(at_begin, at_last), 0.0f};
  const float largest = std::max(std::fabs(at_begin), std::fabs(at_last));
  const float pad = largest * 0x1p-20f + 4.0f * std::numeric_limits<float>::min();
  const float slope = static_cast<float>((static_cast<double>(at_last) - at_begin) / duration);
  if (!std::isfinite(slope)) return make_face(at_begin, at_last, 0.0f, upper);
  const float plane = std::nextafter(upper ? at_begin + pad : at_begin - pad, outwards);
  return {plane, slope};
}

LinkKind NodePlan::kind() const {
  bool moves = false;
  for (const Child& child : std::span(children).first(count)) {
    if (!(child.range == range)) return LinkKind::kSpatialTemporalNode;
    moves = moves || !child.bounds.is_static();
  }
  return moves ? LinkKind::kLinearNode : LinkKind::kStaticNode;
}

std::size_t node_units(LinkKind kind) {
  constexpr std::size_t units[] = {sizeof(StaticNode) / kUnitBytes, sizeof(LinearNode) / kUnitBytes,
                                   sizeof(SpatialTemporalNode) / kUnitBytes};
  return units[static_cast<std::size_t>(kind)];
}

void write_node(const NodePlan& plan, std::byte* out) {
  switch (plan.kind()) {
    case LinkKind::kStaticNode:
      return write_as<StaticNode>(plan, out);
    case LinkKind::kLinearNode:
      return write_as<LinearNode>(plan, out);
    default:
      return write_as<SpatialTemporalNode>(plan, out);
  }
}

}  // namespace stbvh
