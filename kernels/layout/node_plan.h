/// A node before it is bytes: which children it has, and where they lead.
#pragma once

#include <array>
#include <cstddef>

#include "layout/closed_time_range.h"
#include "layout/layout.h"
#include "layout/linear_bounds.h"

namespace stbvh {

/// One face of linear bounds as plane + (t - begin) * slope, evaluated in float with or without fma, outside
/// the line between its places at both ends of the time range at every float t between. With m the larger
/// magnitude, rounding of duration, plane, slope, t - begin, product and sum stays below 10 * 2^-24 * m
/// (docs/accuracy.md).
struct Face {
  float plane, slope;
};
Face make_face(float at_begin, float at_last, float duration, bool upper);

struct NodePlan {
  struct Child {
    LinearBounds bounds;  ///< over its range
    ClosedTimeRange range;
    Link link;
  };

  ClosedTimeRange range;
  std::array<Child, kWidth> children;
  std::size_t count = 0;

  /// The smallest kind of node that holds these children; their links do not matter.
  LinkKind kind() const;
};

/// Units of memory that a node of this kind takes.
std::size_t node_units(LinkKind kind);

}  // namespace stbvh
