/// The linear bounds of boxes at several times.
#pragma once

#include <span>

#include "layout/linear_bounds.h"

namespace stbvh {

/// Box of the geometry at one time, as a parameter in [0, 1] of the time range.
struct BoundsSample {
  float parameter;
  Box4 box;
};

/// For each face the line outside all samples that is tightest at the centre: the edge of their convex hull
/// that spans the centre. Optimal for SA'. Samples ascend in parameter, from 0 to 1.
/// More than two are rounded outwards, for the rounding of parameters and lines.
LinearBounds tightest_at_centre(std::span<const BoundsSample> samples);

}  // namespace stbvh
