#include "layout/node_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace stbvh {

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

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

}  // namespace stbvh
