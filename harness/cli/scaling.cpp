/// Structures over a scene that grows, or with more and more threads.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "harness/cli/commands.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/options.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/scene_options.h"
#include "harness/program/session.h"
#include "harness/program/usage_error.h"
#include "harness/program/whole_numbers.h"
#include "harness/report/machine.h"
#include "harness/report/table.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostTriangles = 100'000'000;
constexpr std::size_t kMostPercent = 1000;
constexpr std::size_t kMostPowers = 12;  ///< of ten
constexpr double kBuildBudget = 20;      // seconds

/// What a run varies.
enum class Over { kSteps, kTriangles, kThreads, kBytes, kTolerance };
constexpr std::array<std::string_view, 5> kOverNames{"steps", "triangles", "threads", "bytes", "tolerance"};

std::string_view over_name(Over over) {
  return kOverNames[static_cast<std::size_t>(over)];
}

struct ScalingOptions : RecordOptions, SpeedOptions {
  Over over = Over::kSteps;
  std::vector<std::size_t> values;  ///< of what varies; empty: default_values()
  std::string scene = "cloth";
  std::optional<double> scale;
  std::uint64_t seed = 1;
  Resampling resampling;
  double tolerance = 0;  ///< of the diagonal
  MemoryBudget max_bytes;
  std::vector<std::string> structures;
  std::optional<unsigned> threads;
};

void add_options(CLI::App& app, ScalingOptions& o) {
  o.count = 100'000;
  o.build_budget_s = kBuildBudget;
  app.add_option_function<std::string>(
         "--over",
         [&o](const auto& name) { o.over = static_cast<Over>(index_of("thing to vary", name, kOverNames)); },
         "steps, triangles (only builds), threads; bytes: percentages of embree's that structures that can "
         "may take; or tolerance: 4 is 1e-4 of the diagonal")
      ->required();
  add_whole_numbers_option(
      app, "--values", [&o](const auto& values) { o.values = values; },
      "How many of them, separated by commas. Default: 2 to 129 steps, 100000 to 1000000 "
      "triangles, 1 to all threads, 20 to 200 % of the bytes, 1e-2 to 1e-6");
  const auto choose = [&o](const std::string& name) {
    std::vector<std::string_view> known;
    for (const ProceduralScene& scene : procedural_scenes()) known.push_back(scene.name);
    index_of("built-in scene", name, known);
    o.scene = name;
  };
  app.add_option_function<std::string>(
         "--scene", choose,
         "Built-in scene; over steps and triangles cloth or barbarian-rotate, which "
         "have any number of them")
      ->default_str(o.scene);
  add_scale_option(app, o.scale);
  add_seed_option(app, o.seed, "Seed of scene and rays");
  add_resampling_option(app, o.resampling);
  add_tolerance_option(app, o.tolerance);
  add_max_bytes_option(app, o.max_bytes);
  add_structures_option(app, o.structures);
  add_json_option(app, o);
  add_threads_option(app, o.threads, kPinnedThreads);
  add_count_option(app, o.count);
  add_repeats_option(app, o.repeats);
  add_build_budget_option(
      app, o.build_budget_s,
      "Seconds within which a structure is built again, for the median; one whose build took "
      "longer is left out of larger scenes. 0: built once, none left out");
}

/// What is measured where --values does not say.
std::vector<std::size_t> default_values(Over over) {
  switch (over) {
    case Over::kSteps:
      return {2, 3, 5, 9, 17, 33, 65, 129};
    case Over::kTriangles:
      return {100'000, 200'000, 500'000, 1'000'000};
    case Over::kBytes:
      return {20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 90, 100, 120, 140, 160, 180, 200};
    case Over::kTolerance:
      return {2, 3, 4, 5, 6};
    case Over::kThreads:
      break;
  }
  std::vector<std::size_t> counts;
  for (std::size_t count = 1; count <= usable_core_count(); ++count) counts.push_back(count);
  return counts;
}

/// With values ascending, and all that follows from what varies.
ScalingOptions completed(ScalingOptions o) {
  if (o.values.empty()) o.values = default_values(o.over);
  std::sort(o.values.begin(), o.values.end());
  o.values.erase(std::unique(o.values.begin(), o.values.end()), o.values.end());
  if (o.over == Over::kSteps && o.values.front() < 2) throw UsageError("--values: at least 2 steps.");
  const std::size_t most = o.over == Over::kSteps       ? kMaxSteps
                           : o.over == Over::kThreads   ? usable_core_count()
                           : o.over == Over::kBytes     ? kMostPercent
                           : o.over == Over::kTolerance ? kMostPowers
                                                        : kMostTriangles;
  check_range("--values", o.values.front(), most);
  check_range("--values", o.values.back(), most);
  if (o.over == Over::kTriangles && o.scale)
    throw UsageError("--scale: with --over triangles, --values says how many.");
  if (o.over == Over::kBytes && (o.max_bytes.bytes || o.max_bytes.share))
    throw UsageError("--max-bytes: with --over bytes, --values says how many.");
  if (o.over == Over::kTolerance && o.tolerance > 0)
    throw UsageError("--tolerance: with --over tolerance, --values says how large.");
  if (o.over == Over::kSteps && o.resampling.steps > 0)
    throw UsageError("--resample-steps: with --over steps, --values says how many.");
  const bool varies_scene = o.over == Over::kSteps || o.over == Over::kTriangles;
  if (varies_scene && find_procedural_scene(o.scene)->make_with_steps == nullptr)
    throw UsageError(
        fmt::format("--scene: over {}, cloth or barbarian-rotate, not {}.", over_name(o.over), o.scene));
  if (o.over == Over::kThreads && o.threads)
    throw UsageError("--threads: with --over threads, --values says how many.");
  o.rays = {RayKind::kBounce, RayKind::kUniform};
  if (o.over == Over::kTriangles) o.rays.clear();
  o.thread_counts = {o.threads.value_or(usable_core_count())};
  return o;
}

/// One scaling run.
class ScalingRun {
 public:
  explicit ScalingRun(const ScalingOptions& options)
      : options_(options),
        source_(*find_procedural_scene(options.scene)),
        names_(with_reference(options.structures)) {
    if (options.over == Over::kTriangles && scale_for(source_.name, options.values.back()) > kMaxScale) {
      throw UsageError(fmt::format("--values: {} has at most {:.0f} triangles, not {}.", source_.name,
                                   kMaxScale / scale_for(source_.name, 1), options.values.back()));
    }
  }

  std::vector<ScalingResult> run() {
    for (std::size_t value : options_.values) {
      if (names_.empty()) break;
      measure(value);
      if (options_.over == Over::kBytes || options_.over == Over::kTolerance) go_on_with_embree_and_ours();
      if (options_.over == Over::kSteps || options_.over == Over::kTriangles) leave_out_slow_builds(value);
    }
    progress_.clear();
    return std::move(results_);
  }

 private:
  Scene make_scene(std::size_t value) const {
    const double scale = options_.over == Over::kTriangles ? scale_for(source_.name, value)
                                                           : options_.scale.value_or(source_.default_scale);
    Scene scene = options_.over == Over::kSteps ? source_.make_with_steps(scale, options_.seed, value)
                                                : source_.make(scale, options_.seed);
    const double tolerance =
        options_.over == Over::kTolerance ? std::pow(10, -static_cast<double>(value)) : options_.tolerance;
    MemoryBudget budget = options_.max_bytes;
    if (options_.over == Over::kBytes) budget.share = static_cast<double>(value) / 100;
    return handed_over(checked(std::move(scene), options_.scene), options_.resampling, tolerance, budget);
  }

  void measure(std::size_t value) {
    SpeedOptions speed = options_;
    if (options_.over == Over::kThreads) speed.thread_counts = {static_cast<unsigned>(value)};
    const std::string over(over_name(options_.over));
    progress_.stage(fmt::format("{} {}: making the scene", value, over));
    const Scene scene = make_scene(value);
    progress_.clear();
    fmt::print("{}with {}\n", scene_heading(summarize(scene)), in_words(value));
    std::fflush(stdout);
    const SceneFigures figures = measure_scene(scene, names_, speed, options_.seed, progress_);
    add_scaling_results(figures, over, value, results_);
  }

  std::string in_words(std::size_t value) const {
    if (options_.over == Over::kBytes) return fmt::format("{} % of embree's bytes", value);
    if (options_.over == Over::kTolerance) return fmt::format("a tolerance of 1e-{} of the diagonal", value);
    return fmt::format("{} {}", value, over_name(options_.over));
  }

  /// Others are the same with every limit and tolerance.
  void go_on_with_embree_and_ours() {
    std::erase_if(names_, [](const std::string& name) { return !is_limitable(name) && name != "embree"; });
  }

  /// Goes on without the structures whose build at `value` took longer than the build budget.
  void leave_out_slow_builds(std::size_t value) {
    if (options_.build_budget_s <= 0 || value == options_.values.back()) return;
    progress_.clear();
    for (const ScalingResult& r : results_) {
      if (r.value != value || r.build.build_s.median <= options_.build_budget_s) continue;
      fmt::print("{} left out of larger scenes: its build took {:.1f} s, more than the budget of {:g} s.\n",
                 r.build.structure, r.build.build_s.median, options_.build_budget_s);
      std::erase(names_, r.build.structure);
    }
  }

  const ScalingOptions& options_;
  const ProceduralScene& source_;
  std::vector<std::string> names_;  ///< of the structures that are still measured
  Progress progress_;
  std::vector<ScalingResult> results_;
};

void run_scaling(const ScalingOptions& asked) {
  const ScalingOptions options = completed(asked);
  if (options.json) check_writable(*options.json);
  ScalingRun scaling(options);
  fmt::print("{}", machine_line(this_machine(), built_commit()));
  Report report;
  report.scalings = scaling.run();
  fmt::print("{}", scaling_table(report.scalings));
  write_records(options, report);
}

}  // namespace

Work scaling_command(CLI::App& app) {
  return make_work(app, run_scaling);
}

}  // namespace stbvh::harness
