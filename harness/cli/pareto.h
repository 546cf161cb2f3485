/// Speed against error: one point for each structure.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "harness/report/records.h"

namespace stbvh::harness {

/// A point for each of `structures`: speed from its bounce and uniform rays with the most threads, errors
/// from the families of hard cases that say something of them, among `hards`. 0 where there is nothing to
/// take from.
std::vector<ParetoResult> pareto_points(std::span<const std::string> structures,
                                        std::span<const SpeedResult> speeds,
                                        std::span<const HardResult> hards);

}  // namespace stbvh::harness
