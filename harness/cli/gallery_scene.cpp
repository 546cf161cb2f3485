#include "harness/cli/gallery_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

/// A triangle for each of `step_counts`, which stands still; obstacle() looks at no more.
Scene scene_with_steps(std::span<const std::size_t> step_counts) {
  Scene scene;
  for (const std::size_t steps : step_counts) {
    Mesh mesh;
    mesh.indices = {0, 1, 2};
    mesh.steps.assign(steps, VertexBuffer(3));
    scene.meshes.push_back(std::move(mesh));
  }
  return scene;
}

bool takes(std::string_view structure, std::size_t steps) {
  return obstacle(structure, scene_with_steps({&steps, 1})).empty();
}

bool takes_uneven(std::string_view structure) {
  constexpr std::size_t kSteps = 3;
  Scene scene = scene_with_steps({&kSteps, 1});
  scene.meshes.front().step_times = {0.0f, 0.25f, 1.0f};
  return obstacle(structure, scene).empty();
}

bool takes_unlike(std::string_view structure) {
  constexpr std::size_t kCounts[]{3, 4};
  return obstacle(structure, scene_with_steps(kCounts)).empty();
}

GalleryResult::Visits count_visits(const StructureUnderTest& structure, std::span<const RaySet> sets) {
  TraversalCounters counters;
  std::size_t rays = 0;
  for (const RaySet& set : sets) {
    if (set.kind != RayKind::kBounce && set.kind != RayKind::kUniform) continue;
    rays += set.rays.size();
    for (const Ray& ray : set.rays) {
      Hit hit;
      structure.intersect_one_counted(ray, hit, counters);
    }
  }
  const auto mean = [&](std::uint64_t count) {
    return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(rays, 1));
  };
  return {mean(counters.nodes), mean(counters.leaves), mean(counters.triangle_tests)};
}

GalleryResult new_result(const Scene& scene, const std::string& name) {
  return {.scene = scene.name,
          .structure = name,
          .compared_with = std::string(compared_with(name)),
          .is_exact = is_exact(name),
          .steps = steps_taken(name)};
}

}  // namespace

std::string_view compared_with(std::string_view structure) {
  return kGalleryReferences[is_scalar(structure) ? 1 : 0];
}

std::string steps_taken(std::string_view structure) {
  std::size_t most = 1, beyond = kMaxSteps + 1;  // the answer is in [most, beyond)
  while (beyond - most > 1) {
    const std::size_t middle = most + (beyond - most) / 2;
    (takes(structure, middle) ? most : beyond) = middle;
  }
  const bool is_any = most == kMaxSteps;
  std::string text = is_any ? "any" : fmt::format("{}", most);
  if (!takes_unlike(structure)) text += ", alike";
  if (!takes_uneven(structure)) text += ", even";
  return text;
}

void GalleryScene::on_built(const std::string& name, const StructureUnderTest& structure,
                            std::span<const RaySet> sets) {
  const auto is_known = [&](const GalleryResult& r) { return r.structure == name; };
  if (std::ranges::any_of(results_, is_known)) return;
  if (!judged_) judged_.emplace(scene_, sets, progress_);
  progress_.stage(fmt::format("{}: asking {}", scene_.name, name));
  GalleryResult result = new_result(scene_, name);
  for (ErrorResult& error : judged_->judge(name, structure, threads_)) {
    result.traced += error.traced;
    result.wrong += error.missed + error.false_hits + error.wrong_primitive;
    errors_.push_back(std::move(error));
  }
  if (structure.has_counters()) result.visits = count_visits(structure, sets);
  if (result.is_exact && result.wrong > 0) warn(result);
  results_.push_back(std::move(result));
}

void GalleryScene::warn(const GalleryResult& result) {
  progress_.clear();
  fmt::print("WRONG: {} promises exact answers, and {} of {} in {} are wrong.\n", result.structure,
             result.wrong, result.traced, result.scene);
  std::fflush(stdout);
}

std::vector<GalleryResult> GalleryScene::results(const std::vector<std::string>& names) const {
  std::vector<GalleryResult> all;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(results_, name, &GalleryResult::structure);
    if (found != results_.end()) {
      all.push_back(*found);
      continue;
    }
    all.push_back(new_result(scene_, name));
    all.back().obstacle = obstacle(name, scene_);
    if (all.back().obstacle.empty()) all.back().obstacle = "it did not fit into memory";
  }
  return all;
}

}  // namespace stbvh::harness
