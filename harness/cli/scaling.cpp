/// Structures over a scene that grows, or with more and more threads.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "harness/cli/commands.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/session.h"
#include "harness/program/usage_error.h"
#include "harness/report/machine.h"
#include "harness/report/table.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

/// The scale at which `scene` has about that many moving triangles.
double scale_for(const ProceduralScene& scene, std::size_t triangles) {
  double at_one = 0;
  for (const StepGroup& group : planned_groups(scene.name)) at_one += group.triangles;
  return static_cast<double>(triangles) / at_one;
}

/// One scaling run.
class ScalingRun {
 public:
  explicit ScalingRun(const Options& options)
      : options_(options),
        source_(*find_procedural_scene(options.scenes.front())),
        names_(with_reference(options.structures)) {
    if (options.over == Over::kTriangles && scale_for(source_, options.values.back()) > kMaxScale) {
      throw UsageError(fmt::format("--values: {} has at most {:.0f} triangles, not {}.", source_.name,
                                   kMaxScale / scale_for(source_, 1), options.values.back()));
    }
  }

  std::vector<ScalingResult> run() {
    for (std::size_t value : options_.values) {
      if (names_.empty()) break;
      measure(value);
      if (options_.over != Over::kThreads) leave_out_slow_builds(value);
    }
    progress_.clear();
    return std::move(results_);
  }

 private:
  Scene make_scene(std::size_t value) const {
    const double scale = options_.over == Over::kTriangles ? scale_for(source_, value)
                                                           : options_.scale.value_or(source_.default_scale);
    Scene scene = options_.over == Over::kSteps ? source_.make_with_steps(scale, options_.seed, value)
                                                : source_.make(scale, options_.seed);
    return checked(std::move(scene), options_.scenes.front());
  }

  void measure(std::size_t value) {
    Options options = options_;
    if (options.over == Over::kThreads) {
      options.threads = static_cast<unsigned>(value);
      options.thread_counts = {options.threads};
    }
    progress_.stage(fmt::format("{} {}: making the scene", value, over_name(options.over)));
    const Scene scene = make_scene(value);
    progress_.clear();
    fmt::print("{}with {} {}\n", scene_heading(summarize(scene)), value, over_name(options.over));
    std::fflush(stdout);
    const SceneFigures figures = measure_scene(scene, names_, options, progress_);
    for (const BuildResult& build : figures.builds) {
      ScalingResult& result = results_.emplace_back(
          ScalingResult{.over = std::string(over_name(options.over)), .value = value, .build = build});
      std::copy_if(figures.speeds.begin(), figures.speeds.end(), std::back_inserter(result.speeds),
                   [&](const SpeedResult& s) { return s.structure == build.structure; });
    }
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

  const Options& options_;
  const ProceduralScene& source_;
  std::vector<std::string> names_;  ///< of the structures that are still measured
  Progress progress_;
  std::vector<ScalingResult> results_;
};

}  // namespace

void run_scaling(const Options& options) {
  if (options.json) check_writable(*options.json);
  ScalingRun scaling(options);
  fmt::print("{}", machine_line(this_machine(), built_commit()));
  Report report;
  report.scalings = scaling.run();
  fmt::print("{}", scaling_table(report.scalings));
  write_records(options, report);
}

}  // namespace stbvh::harness
