/// The gallery: the builder that its methods share, and what they do to it.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "harness/rays/ray_generator.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/scene_views.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

Box3f united(const Box3f& box, const Vec3f& p) {
  return {{std::min(box.lower.x, p.x), std::min(box.lower.y, p.y), std::min(box.lower.z, p.z)},
          {std::max(box.upper.x, p.x), std::max(box.upper.y, p.y), std::max(box.upper.z, p.z)}};
}

struct Work {
  std::uint64_t nodes = 0, leaves = 0, triangles = 0;
  bool operator==(const Work&) const = default;
};

Work work_of(const StructureUnderTest& structure, const std::vector<Ray>& rays) {
  EXPECT_TRUE(structure.has_counters());
  TraversalCounters counters{};
  for (const Ray& ray : rays) {
    Hit hit;
    structure.intersect_one_counted(ray, hit, counters);
  }
  return {counters.nodes, counters.leaves, counters.triangle_tests};
}

std::vector<Ray> uniform_rays(const Scene& scene) {
  const auto reference = build_structure("embree", scene, 1);
  return make_rays(RayKind::kUniform, scene, *reference, 2000, 5).rays;
}

/// Static meshes beside moving ones of few and of many steps.
std::vector<Scene> scenes() {
  std::vector<Scene> scenes;
  scenes.push_back(mixed_step_scene());
  for (const char* const name : {"wheels", "static-city"})
    scenes.push_back(find_procedural_scene(name)->make(0.002, 1));
  return scenes;
}

TEST(Gallery, ItsBuilderMakesTheKernelsTreeWhereNothingIsTakenAway) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    const auto copy = build_structure("no-step-reduction", scene, 2);
    const SceneViews views(scene);
    const auto tree = Structure::build(views.meshes(), {.tolerance = kKeepAllSteps});
    const std::vector<Ray> rays = uniform_rays(scene);
    TraversalCounters counters{};
    for (const Ray& ray : rays) {
      Hit a, b;
      ASSERT_EQ(tree->intersect_counted(ray, a, counters), copy->intersect_one(ray, b));
    }
    EXPECT_EQ(work_of(*copy, rays), (Work{counters.nodes, counters.leaves, counters.triangle_tests}));
    EXPECT_NEAR(static_cast<double>(copy->build_record().structure_bytes),
                static_cast<double>(tree->statistics().structure_bytes), 4096);
  }
}

TEST(Gallery, BuildsTheSameForAnyNumberOfThreads) {
  for (const Scene& scene : scenes()) {
    const std::vector<Ray> rays = uniform_rays(scene);
    for (const std::string_view name : gallery_names()) {
      if (!obstacle(name, scene).empty()) continue;
      SCOPED_TRACE(scene.name + ", " + std::string(name));
      const auto one = build_structure(name, scene, 1), two = build_structure(name, scene, 2);
      EXPECT_EQ(one->build_record().structure_bytes, two->build_record().structure_bytes);
      if (!one->has_counters()) continue;
      EXPECT_EQ(work_of(*one, rays), work_of(*two, rays));
    }
  }
}

/// What each ablation takes away is there to be missed: rays have more to do, or there is more in memory.
TEST(Gallery, EachAblationChangesTheTree) {
  const std::vector<Scene> all = scenes();
  for (const std::string_view name : gallery_names()) {
    if (!name.starts_with("no-")) continue;
    bool differs = false;
    for (const Scene& scene : all) {
      const auto with = build_structure("stbvh-direct", scene, 2), without = build_structure(name, scene, 2);
      const std::vector<Ray> rays = uniform_rays(scene);
      differs = differs || work_of(*with, rays) != work_of(*without, rays);
    }
    EXPECT_TRUE(differs) << name;
  }
}

/// The bounds of a method at a time hold all triangles as they are then.
TEST(Gallery, WhatIsShownOfATimeHoldsWhatIsThere) {
  const Scene scene = mixed_step_scene(50);
  for (const std::string_view name : gallery_names()) {
    if (!obstacle(name, scene).empty() || !is_exact(name)) continue;
    SCOPED_TRACE(std::string(name));
    const auto structure = build_structure(name, scene, 2);
    for (const bool at_end : {false, true}) {
      Box3f shown = Box3f::empty();
      for (const Outline& outline : structure->outlines_at(at_end ? 1.0f : 0.0f, 2)) {
        for (const Vec3f& corner : outline) shown = united(shown, corner);
      }
      Box3f there = Box3f::empty();
      for (const Mesh& mesh : scene.meshes) {
        if (mesh.time_range.begin > 0.0f) continue;
        const VertexBuffer& vertices = at_end ? mesh.steps.back() : mesh.steps.front();
        for (const Vec3f& p : vertices.span()) there = united(there, p);
      }
      const Box3f both = united(united(shown, there.lower), there.upper);
      EXPECT_EQ(both.lower.x, shown.lower.x);
      EXPECT_EQ(both.lower.y, shown.lower.y);
      EXPECT_EQ(both.lower.z, shown.lower.z);
      EXPECT_EQ(both.upper.x, shown.upper.x);
      EXPECT_EQ(both.upper.y, shown.upper.y);
      EXPECT_EQ(both.upper.z, shown.upper.z);
    }
  }
}

}  // namespace
}  // namespace stbvh::harness
