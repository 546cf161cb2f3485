/// Building and tracing all structures over one scene, against each other.
#pragma once

#include <string>
#include <vector>

#include "harness/cli/options.h"
#include "harness/cli/progress.h"
#include "harness/report/records.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

struct SceneFigures {
  std::vector<BuildResult> builds;
  std::vector<SpeedResult> speeds;  ///< of each thread count, kind of rays and structure
};

/// `names` with the structure that ratios refer to before them.
std::vector<std::string> with_reference(std::vector<std::string> names);

/// Builds those of `names` that fit into memory over `scene` (a line on stdout for each other), traces the
/// rays of `options` with all of them in turn, then builds them again within the build budget. Without kinds
/// of rays they are only built, one at a time.
SceneFigures measure_scene(const Scene& scene, const std::vector<std::string>& names, const Options& options,
                           Progress& progress);

/// Builds the structures of `options`, and embree, over `scene`, traces the same rays with all of them in
/// turn (with each of its thread counts) and adds the figures to `report`. Returns their tables.
std::string bench_scene(const Scene& scene, const Options& options, Progress& progress, Report& report);

}  // namespace stbvh::harness
