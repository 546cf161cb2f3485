#include "harness/scenes/procedural/scene_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace stbvh::harness {
namespace {

constexpr std::array<StepGroup, 2> kLlama{{{3, 7.0e6}, {9, 1.7e6}}};
constexpr std::array<StepGroup, 3> kCrowd{{{2, 7.5e6}, {6, 2.8e6}, {15, 0.1e6}}};
constexpr std::array<StepGroup, 1> kBarbarian{{{15, 0.1e6}}};
constexpr std::array<StepGroup, 1> kBarbarianRotate{{{9, 0.1e6}}};
constexpr std::array<StepGroup, 1> kCloth{{{9, 0.5e6}}};
constexpr std::array<StepGroup, 1> kDancer{{{15, 0.3e6}}};

/// Share of the llama's nine-step triangles that is skin; the rest is short fur.
constexpr double kSkinShare = 0.55;
/// Triangles of a figure in the crowd at scale 1, and figures below which a crowd would not look like one.
constexpr double kFigureTriangles = 26000;
constexpr double kFewestFigures = 64;
/// Below this a figure of the crowd would not look like one.
constexpr double kFewestFigureTriangles = 1500;

std::size_t rounded(double x) {
  return static_cast<std::size_t>(std::llround(x));
}

}  // namespace

std::span<const StepGroup> planned_groups(std::string_view scene) {
  if (scene == "llama") return kLlama;
  if (scene == "crowd") return kCrowd;
  if (scene == "barbarian") return kBarbarian;
  if (scene == "barbarian-rotate") return kBarbarianRotate;
  if (scene == "cloth") return kCloth;
  if (scene == "dancer") return kDancer;
  return {};
}

double scale_for(std::string_view scene, std::size_t triangles) {
  double at_one = 0;
  for (const StepGroup& group : planned_groups(scene)) at_one += group.triangles;
  return static_cast<double>(triangles) / at_one;
}

std::size_t planned_triangles(std::string_view scene, std::size_t steps, double scale) {
  if (!(scale > 0 && scale <= kMaxScale))
    throw std::invalid_argument(
        fmt::format("the scale of a scene must lie in (0, {}], not {}", kMaxScale, scale));
  double triangles = 0;
  for (const StepGroup& group : planned_groups(scene))
    triangles += group.steps == steps ? group.triangles : 0;
  return std::max<std::size_t>(rounded(triangles * scale), 64);
}

CrowdPlan plan_crowd(std::size_t steps, double scale) {
  const auto triangles = static_cast<double>(planned_triangles("crowd", steps, scale));
  const double everybody = (7.5e6 + 2.8e6 + 0.1e6) * scale;
  const double per_figure =
      std::min(kFigureTriangles, std::max(everybody / kFewestFigures, kFewestFigureTriangles));
  const std::size_t figures = std::max<std::size_t>(rounded(triangles / per_figure), 1);
  return {figures, rounded(triangles / static_cast<double>(figures))};
}

LlamaPlan plan_llama(double scale) {
  const auto fur = static_cast<double>(planned_triangles("llama", 3, scale));
  const auto near = static_cast<double>(planned_triangles("llama", 9, scale));
  return {rounded(fur / static_cast<double>(strand_triangles(kLongStrandSegments))),
          rounded(near * kSkinShare),
          rounded(near * (1 - kSkinShare) / static_cast<double>(strand_triangles(kShortStrandSegments)))};
}

}  // namespace stbvh::harness
