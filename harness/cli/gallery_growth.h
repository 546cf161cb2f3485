/// How the structures of the gallery grow with steps and with the curvature of the motion.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "harness/cli/scene_bench.h"
#include "harness/program/progress.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// Measures `names` over barbarian-rotate with 2 to 129 steps, and over a bar that turns up to twice in 33
/// steps, each of about `triangles`. A structure whose build took longer than 20 s is left out of what comes
/// after it.
std::vector<ScalingResult> measure_growth(const std::vector<std::string>& names, const SpeedOptions& options,
                                          std::size_t triangles, std::uint64_t seed, Progress& progress);

}  // namespace stbvh::harness
