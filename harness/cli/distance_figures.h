/// From the errors of distances to the figures that tables and records hold.
#pragma once

#include "harness/oracle/judge.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// `errors` is sorted.
DistanceFigures distance_figures(const DistanceErrors& errors);

}  // namespace stbvh::harness
