#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "harness/rays/ray_generator.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

class Rays : public ::testing::TestWithParam<RayKind> {
 protected:
  const Scene scene_ = mixed_step_scene();
  const std::unique_ptr<StructureUnderTest> reference_ = build_structure("embree-robust", scene_, 0);

  RaySet make(std::size_t count, std::uint64_t seed) const {
    return make_rays(GetParam(), scene_, *reference_, count, seed);
  }
};

TEST_P(Rays, AreDeterministicBySeed) {
  const RaySet a = make(3000, 1);
  const RaySet b = make(3000, 1);
  const RaySet c = make(3000, 2);
  ASSERT_EQ(a.rays.size(), 3000u);
  ASSERT_EQ(b.rays.size(), 3000u);
  EXPECT_EQ(std::memcmp(a.rays.data(), b.rays.data(), 3000 * sizeof(Ray)), 0);
  EXPECT_NE(std::memcmp(a.rays.data(), c.rays.data(), 3000 * sizeof(Ray)), 0);
}

TEST_P(Rays, AreTraceableAndSpreadOverTime) {
  const RaySet set = make(3000, 1);
  EXPECT_EQ(set.kind, GetParam());
  double sum = 0;
  for (const Ray& ray : set.rays) {
    ASSERT_TRUE(is_traceable(ray));
    sum += ray.time;
    EXPECT_NEAR(length(to_double(ray.direction)), 1, 1e-6);
  }
  EXPECT_NEAR(sum / 3000, 0.5, 0.05);
}

TEST_P(Rays, NamesAreFound) {
  EXPECT_EQ(find_ray_kind(ray_kind_name(GetParam())), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Kinds, Rays, ::testing::ValuesIn(ray_kinds().begin(), ray_kinds().end()),
                         [](const auto& p) {
                           std::string name(ray_kind_name(p.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(RayGenerator, HalfOfTheUniformRaysAreAimedAtGeometry) {
  const Scene scene = mixed_step_scene(50);  // thin: random directions mostly miss
  const auto reference = build_structure("embree-robust", scene, 0);
  const RaySet set = make_rays(RayKind::kUniform, scene, *reference, 4000, 1);
  std::vector<HitRecord> hits(set.rays.size());
  reference->intersect(set.rays, hits);
  std::size_t aimed = 0;
  for (std::size_t i = 1; i < hits.size(); i += 2) {
    if (hits[i].is_hit()) ++aimed;
  }
  EXPECT_GE(aimed, hits.size() / 2 - 2);
}

TEST(RayGenerator, OccludedKindsHaveTheRaysOfTheOthers) {
  const Scene scene = mixed_step_scene();
  const auto reference = build_structure("embree-robust", scene, 0);
  for (const auto& [closest, occluded] : {std::pair{RayKind::kBounce, RayKind::kBounceOccluded},
                                          std::pair{RayKind::kUniform, RayKind::kUniformOccluded}}) {
    const RaySet a = make_rays(closest, scene, *reference, 500, 1);
    const RaySet b = make_rays(occluded, scene, *reference, 500, 1);
    EXPECT_FALSE(a.any_hit());
    EXPECT_TRUE(b.any_hit());
    EXPECT_EQ(std::memcmp(a.rays.data(), b.rays.data(), 500 * sizeof(Ray)), 0);
  }
}

TEST(RayGenerator, SceneThatIsNeverHitGivesNoBounceRays) {
  Scene scene;
  scene.meshes.push_back(one_triangle({{{{0, 0, 0}, {1, 0, 1}, {0, 2, 2}}}}));
  scene.meshes[0].indices[0] = 3;  // out of range
  const auto reference = build_structure("embree-robust", scene, 0);
  EXPECT_TRUE(make_rays(RayKind::kBounce, scene, *reference, 100, 1).rays.empty());
}

TEST(RayGenerator, WhatEmbreeCannotTakeIsNotTraceable) {
  const Ray good = ray_along_z(0, 0);
  const auto with = [&](auto change) {
    Ray ray = good;
    change(ray);
    return is_traceable(ray);
  };
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float inf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(is_traceable(good));
  EXPECT_FALSE(with([](Ray& r) { r.origin.x = nan; }));
  EXPECT_FALSE(with([](Ray& r) { r.origin.y = inf; }));
  EXPECT_FALSE(with([](Ray& r) { r.direction.z = nan; }));
  EXPECT_FALSE(with([](Ray& r) { r.direction = {0, 0, 0}; }));
  EXPECT_FALSE(with([](Ray& r) { r.time = nan; }));
  EXPECT_FALSE(with([](Ray& r) { r.time = 1.5f; }));
  EXPECT_FALSE(with([](Ray& r) { r.tnear = -1; }));
  EXPECT_FALSE(with([](Ray& r) { r.tfar = nan; }));
  EXPECT_TRUE(with([](Ray& r) { r.tfar = inf; }));
}

}  // namespace
}  // namespace stbvh::harness
