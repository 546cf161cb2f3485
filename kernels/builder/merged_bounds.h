/// The linear bounds of a node, from those of its children.
#pragma once

#include <span>

#include "layout/closed_time_range.h"
#include "layout/linear_bounds.h"

namespace stbvh {

struct TimedBounds {
  LinearBounds bounds;
  ClosedTimeRange range;  ///< over which they hold
};

/// Over `range`, of children that may be alive in parts of it only. One to eight.
LinearBounds merged_bounds(const ClosedTimeRange& range, std::span<const TimedBounds> children);

}  // namespace stbvh
