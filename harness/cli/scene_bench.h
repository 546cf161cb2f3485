/// Building and tracing all structures over one scene, against each other.
#pragma once

#include "harness/cli/options.h"
#include "harness/cli/progress.h"
#include "harness/report/records.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Builds the structures of `options`, and embree, over `scene`, traces the same rays with all of them in
/// turn (with each of its thread counts), prints the tables and adds their rows to `report`.
void bench_scene(const Scene& scene, const Options& options, Progress& progress, Report& report);

}  // namespace stbvh::harness
