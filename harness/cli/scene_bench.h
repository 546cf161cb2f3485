/// Building and tracing all structures over one scene, against each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "harness/program/options.h"
#include "harness/program/session.h"
#include "harness/rays/ray_set.h"
#include "harness/report/records.h"
#include "harness/scenes/scene.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// How structures are measured over a scene.
struct SpeedOptions : RayOptions {
  std::vector<unsigned> thread_counts;  ///< that speeds are measured with, ascending
  std::size_t repeats = 7;
  double build_budget_s = 3;

  /// Of the builds.
  unsigned threads() const { return thread_counts.back(); }
};

/// Rays of each kind where --count is not given.
inline constexpr std::size_t kDefaultBenchRays = 100'000;

struct BenchOptions : SessionOptions, SpeedOptions {
  std::vector<std::string> structures;
};

void add_options(CLI::App& app, BenchOptions& options);
void run_bench(const BenchOptions& options);

/// --build-budget: what `budget_s` says where it is not given.
void add_build_budget_option(CLI::App& app, double& budget_s, const char* description);

struct SceneFigures {
  std::vector<BuildResult> builds;
  std::vector<SpeedResult> speeds;  ///< of each thread count, kind of rays and structure
};

/// `names` with the structure that ratios refer to before them.
std::vector<std::string> with_reference(std::vector<std::string> names);

/// Told of each structure when it has been built, before it is traced with the rays. The one that ratios
/// refer to is built more than once where not all structures fit into memory together.
using OnBuilt =
    std::function<void(const std::string& name, const StructureUnderTest&, std::span<const RaySet>)>;

/// Builds those of `names` that fit into memory over `scene` (a line on stdout for each other), traces the
/// rays of `options` by `seed` with all of them in turn, then builds them again within the build budget.
/// Without kinds of rays they are only built, one at a time.
SceneFigures measure_scene(const Scene& scene, const std::vector<std::string>& names,
                           const SpeedOptions& options, std::uint64_t seed, Progress& progress,
                           const OnBuilt& on_built = {});

/// Adds what was measured at one value of what varies: a result for each structure.
void add_scaling_results(const SceneFigures& figures, const std::string& over, std::size_t value,
                         std::vector<ScalingResult>& results);

/// Builds the structures of `options`, and embree, over `scene`, traces the same rays with all of them in
/// turn (with each of its thread counts) and adds the figures to `report`. Returns their tables.
std::string bench_scene(const Scene& scene, const BenchOptions& options, Progress& progress, Report& report);

}  // namespace stbvh::harness
