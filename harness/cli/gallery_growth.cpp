#include "harness/cli/gallery_growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "harness/cli/turning_bar.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr std::string_view kStepScene = "barbarian-rotate";
constexpr std::size_t kStepCounts[]{2, 3, 5, 9, 17, 33, 65, 129};
constexpr std::size_t kQuarterTurns[]{0, 1, 2, 3, 4, 5, 6, 7, 8};
constexpr std::size_t kBarSteps = 33;
constexpr double kSlowBuild = 20;  // seconds

Scene figure_with_steps(std::size_t steps, std::size_t triangles, std::uint64_t seed) {
  Scene scene =
      find_procedural_scene(kStepScene)->make_with_steps(scale_for(kStepScene, triangles), seed, steps);
  scene.name = kStepScene;
  return scene;
}

using MakeScene = std::function<Scene(std::size_t value)>;

/// Growth over one thing.
class GrowthRun {
 public:
  GrowthRun(std::vector<std::string> names, const SpeedOptions& options, std::uint64_t seed,
            Progress& progress)
      : names_(std::move(names)), options_(options), seed_(seed), progress_(progress) {}

  void run(const char* over, std::span<const std::size_t> values, const MakeScene& make_scene,
           std::vector<ScalingResult>& results) {
    for (const std::size_t value : values) {
      progress_.stage(fmt::format("{} {}: making the scene", value, over));
      const Scene scene = make_scene(value);
      std::vector<std::string> names = names_;
      std::erase_if(names, [&](const std::string& name) { return !obstacle(name, scene).empty(); });
      const SceneFigures figures = measure_scene(scene, names, options_, seed_, progress_);
      add_scaling_results(figures, over, value, results);
      for (const BuildResult& build : figures.builds) {
        if (build.build_s.median > kSlowBuild && value != values.back()) leave_out(build, value, over);
      }
    }
  }

 private:
  void leave_out(const BuildResult& build, std::size_t value, const char* over) {
    progress_.clear();
    fmt::print("{} left out beyond {} {}: its build took {:.1f} s.\n", build.structure, value, over,
               build.build_s.median);
    std::erase(names_, build.structure);
  }

  std::vector<std::string> names_;  ///< of the structures that are still measured
  const SpeedOptions& options_;
  std::uint64_t seed_;
  Progress& progress_;
};

}  // namespace

std::vector<ScalingResult> measure_growth(const std::vector<std::string>& names, const SpeedOptions& options,
                                          std::size_t triangles, std::uint64_t seed, Progress& progress) {
  SpeedOptions speed = options;
  speed.rays = {RayKind::kBounce, RayKind::kUniform};
  speed.build_budget_s = 0;
  std::vector<ScalingResult> results;
  GrowthRun(names, speed, seed, progress)
      .run(
          "steps", kStepCounts, [&](std::size_t steps) { return figure_with_steps(steps, triangles, seed); },
          results);
  GrowthRun(names, speed, seed, progress)
      .run(
          "quarter turns", kQuarterTurns,
          [&](std::size_t quarters) {
            return make_turning_bar(0.25 * static_cast<double>(quarters), kBarSteps, triangles);
          },
          results);
  return results;
}

}  // namespace stbvh::harness
