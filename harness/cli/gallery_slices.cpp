#include "harness/cli/gallery_slices.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "harness/cli/turning_bar.h"
#include "harness/scenes/frozen_scene.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr double kTurns = 0.5;
constexpr std::size_t kSteps = 9;
constexpr std::size_t kTriangles = 96;
constexpr std::array<float, 5> kTimes{0.03f, 0.27f, 0.47f, 0.72f, 0.97f};
constexpr std::size_t kLeaves = 100;  // levels below the root: deeper than any tree of so few triangles

SliceResult slice_of(const Scene& scene, const std::string& structure, float time) {
  return {.scene = scene.name, .structure = structure, .time = static_cast<double>(time)};
}

SliceResult triangles_at(const Scene& scene, float time) {
  SliceResult slice = slice_of(scene, "", time);
  const Scene still = frozen(scene, time);
  for (const Mesh& mesh : still.meshes) {
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      auto& shape = slice.shapes.emplace_back();
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const Vec3f p = mesh.steps.front()[mesh.indices[i + corner]];
        shape.push_back({p.x, p.y});
      }
    }
  }
  return slice;
}

SliceResult bounds_at(const Scene& scene, const std::string& name, const StructureUnderTest& structure,
                      float time) {
  SliceResult slice = slice_of(scene, name, time);
  for (const Outline& outline : structure.outlines_at(time, kLeaves)) {
    auto& shape = slice.shapes.emplace_back();
    for (const Vec3f corner : outline) shape.push_back({corner.x, corner.y});
  }
  return slice;
}

}  // namespace

std::vector<SliceResult> slices_of(const std::vector<std::string>& names, Progress& progress) {
  const Scene scene = make_turning_bar(kTurns, kSteps, kTriangles);
  std::vector<SliceResult> slices;
  for (const float time : kTimes) slices.push_back(triangles_at(scene, time));
  for (const std::string& name : names) {
    if (!obstacle(name, scene).empty()) continue;
    progress.stage(fmt::format("time slices: {}", name));
    const auto structure = build_structure(name, scene, 1);
    for (const float time : kTimes) {
      SliceResult slice = bounds_at(scene, name, *structure, time);
      if (!slice.shapes.empty()) slices.push_back(std::move(slice));
    }
  }
  return slices;
}

}  // namespace stbvh::harness
