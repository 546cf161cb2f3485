#include "harness/oracle/oracle.h"

#include <gtest/gtest.h>

#include "harness/oracle/judge.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

constexpr std::array<Vec3f, 3> kAtZ0{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
constexpr std::array<Vec3f, 3> kHairBehindZ0{{{0, 0, 1e-8f}, {1, 0, 1e-8f}, {0, 1, 1e-8f}}};
constexpr std::array<Vec3f, 3> kAtZ2{{{0, 0, 2}, {1, 0, 2}, {0, 1, 2}}};
constexpr std::array<Vec3f, 3> kAtZ4{{{0, 0, 4}, {1, 0, 4}, {0, 1, 4}}};

Scene scene_of(std::initializer_list<Mesh> meshes) {
  Scene scene;
  scene.meshes = meshes;
  return scene;
}

TEST(Oracle, StaticTriangleIsHitWherePaperSays) {
  const Scene scene = scene_of({one_triangle({kAtZ0})});
  const OracleAnswer hit = Oracle(scene).answer(ray_along_z(0.25f, 0.25f, 0.7f));
  EXPECT_TRUE(hit.is_hit);
  EXPECT_TRUE(hit.is_certain());
  EXPECT_DOUBLE_EQ(hit.t, 1.0);
  EXPECT_EQ(hit.geom_id, 0u);
  EXPECT_EQ(hit.prim_id, 0u);
  EXPECT_FALSE(hit.is_near_edge);
  EXPECT_FALSE(Oracle(scene).answer(ray_along_z(0.75f, 0.75f)).is_possible);
}

TEST(Oracle, MotionIsLinearWithinEachSegment) {
  const Scene scene = scene_of({one_triangle({kAtZ0, kAtZ4, kAtZ2})});
  const Oracle oracle(scene);
  for (const auto& [time, z] : {std::pair{0.0f, 0.0}, {0.25f, 2.0}, {0.5f, 4.0}, {0.75f, 3.0}, {1.0f, 2.0}}) {
    EXPECT_DOUBLE_EQ(oracle.answer(ray_along_z(0.25f, 0.25f, time)).t, z + 1) << time;
  }
}

TEST(Oracle, MotionIsLinearBetweenStepsAtTimesOfTheirOwn) {
  Mesh mesh = one_triangle({kAtZ0, kAtZ4, kAtZ2});
  mesh.step_times = {0.125f, 0.25f, 0.75f};
  const Scene scene = scene_of({mesh});
  const Oracle oracle(scene);
  EXPECT_FALSE(oracle.answer(ray_along_z(0.25f, 0.25f, std::nextafter(0.125f, 0.0f))).is_possible);
  EXPECT_FALSE(oracle.answer(ray_along_z(0.25f, 0.25f, std::nextafter(0.75f, 1.0f))).is_possible);
  for (const auto& [time, z] :
       {std::pair{0.125f, 0.0}, {0.1875f, 2.0}, {0.25f, 4.0}, {0.5f, 3.0}, {0.625f, 2.5}, {0.75f, 2.0}}) {
    EXPECT_DOUBLE_EQ(oracle.answer(ray_along_z(0.25f, 0.25f, time)).t, z + 1) << time;
  }
}

/// Time may move by three units in the last place: beside a jump that may be as far as it goes, elsewhere it
/// is not.
TEST(Oracle, JumpsCountOnlyForTimesBesideThem) {
  const float after = 0.5f, before = std::nextafter(0.5f, 0.0f);
  Mesh mesh = one_triangle({kAtZ0, kAtZ0, kAtZ4, kAtZ4});
  mesh.step_times = {0, before, after, 1};
  const Scene scene = scene_of({mesh});
  const Oracle oracle(scene);
  for (const auto& [time, z] : {std::pair{0.25f, 0.0}, {before, 0.0}, {after, 4.0}, {0.75f, 4.0}}) {
    const OracleAnswer answer = oracle.answer(ray_along_z(0.25f, 0.25f, time));
    EXPECT_DOUBLE_EQ(answer.t, z + 1) << time;
    const bool is_beside = time == before || time == after;
    EXPECT_NEAR(answer.t_lower, is_beside ? z - 3 : z + 1, is_beside ? 1e-4 : 1e-5) << time;
    EXPECT_NEAR(answer.t_upper, is_beside ? z + 5 : z + 1, is_beside ? 1e-4 : 1e-5) << time;
  }
}

TEST(Oracle, MovingMeshesExistInTheirTimeRangeOnly) {
  Mesh mesh = one_triangle({kAtZ0, kAtZ4});
  mesh.time_range = {0.25f, 0.75f};
  const Scene scene = scene_of({mesh});
  const Oracle oracle(scene);
  EXPECT_FALSE(oracle.answer(ray_along_z(0.25f, 0.25f, 0.2f)).is_possible);
  EXPECT_FALSE(oracle.answer(ray_along_z(0.25f, 0.25f, 0.8f)).is_possible);
  EXPECT_DOUBLE_EQ(oracle.answer(ray_along_z(0.25f, 0.25f, 0.25f)).t, 1.0);
  EXPECT_DOUBLE_EQ(oracle.answer(ray_along_z(0.25f, 0.25f, 0.5f)).t, 3.0);
  EXPECT_DOUBLE_EQ(oracle.answer(ray_along_z(0.25f, 0.25f, 0.75f)).t, 5.0);
}

TEST(Oracle, RayIntervalAndMaskAreHonoured) {
  Mesh masked = one_triangle({kAtZ0});
  masked.mask = 2;
  const Scene scene = scene_of({masked, one_triangle({kAtZ2})});
  const Oracle oracle(scene);
  Ray ray = ray_along_z(0.25f, 0.25f);
  EXPECT_EQ(oracle.answer(ray).geom_id, 0u);
  ray.mask = 1;
  EXPECT_EQ(oracle.answer(ray).geom_id, 1u);
  ray.tfar = 2.5f;
  EXPECT_FALSE(oracle.answer(ray).is_possible);
  ray.tfar = 100;
  ray.tnear = 3.5f;
  EXPECT_FALSE(oracle.answer(ray).is_possible);
}

TEST(Oracle, TInUnitsOfTheDirection) {
  const Scene scene = scene_of({one_triangle({kAtZ0})});
  Ray ray = ray_along_z(0.25f, 0.25f);
  ray.direction = {0, 0, 4};
  EXPECT_DOUBLE_EQ(Oracle(scene).answer(ray).t, 0.25);
}

TEST(Oracle, EdgesAreNear) {
  const Scene scene = scene_of({one_triangle({kAtZ0})});
  const Oracle oracle(scene);
  const OracleAnswer on_edge = oracle.answer(ray_along_z(0.0f, 0.5f));
  EXPECT_TRUE(on_edge.is_hit);
  EXPECT_FALSE(on_edge.is_certain());
  EXPECT_TRUE(on_edge.is_near_edge);
  EXPECT_EQ(on_edge.edge_distance_ulps, 0.0);
  const OracleAnswer outside = oracle.answer(ray_along_z(-1e-7f, 0.5f));
  EXPECT_FALSE(outside.is_hit);
  EXPECT_TRUE(outside.is_possible);
  EXPECT_LT(outside.edge_distance_ulps, kRoundingUlps);
  EXPECT_FALSE(oracle.answer(ray_along_z(-1e-4f, 0.5f)).is_possible);
  EXPECT_TRUE(oracle.answer(ray_along_z(1e-4f, 0.5f)).is_certain());
}

TEST(Oracle, DegenerateAndInvalidTrianglesAreNotHit) {
  const Mesh line = one_triangle({{{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}}});
  Mesh out_of_range = one_triangle({kAtZ0});
  out_of_range.indices[2] = 3;
  Mesh not_finite = one_triangle({kAtZ0, kAtZ2});
  not_finite.steps[1][1].y = std::numeric_limits<float>::quiet_NaN();
  const Scene scene = scene_of({line, out_of_range, not_finite});
  const Oracle oracle(scene);
  EXPECT_FALSE(oracle.answer(ray_along_z(0.25f, 0.25f)).is_hit);
  EXPECT_FALSE(oracle.test(ray_along_z(0.25f, 0.25f), 1, 0).has_value());
  EXPECT_FALSE(oracle.test(ray_along_z(0.25f, 0.25f), 9, 0).has_value());
  EXPECT_FALSE(oracle.test(ray_along_z(0.25f, 0.25f), 0, 9).has_value());
}

TEST(Oracle, CoplanarTrianglesTie) {
  const Scene scene = scene_of({one_triangle({kAtZ0}), one_triangle({kAtZ0}), one_triangle({kAtZ2})});
  const OracleAnswer answer = Oracle(scene).answer(ray_along_z(0.25f, 0.25f));
  EXPECT_EQ(answer.geom_id, 0u);
  EXPECT_EQ(answer.ties, 1u);
}

class Judge : public ::testing::Test {
 protected:
  /// The verdict of one ray through (x, 0.25) that was answered with `hit`.
  Verdict verdict(float x, HitRecord hit, RayKind kind = RayKind::kPrimary) const {
    const RaySet rays{kind, {ray_along_z(x, 0.25f)}};
    const ErrorCounts counts = judge(oracle_, 5.0, rays, oracle_.answers(rays.rays), std::span(&hit, 1));
    if (counts.ties > 0) return Verdict::kTie;
    return counts.differences.empty() ? Verdict::kAgrees : counts.differences.front().verdict;
  }

  static constexpr HitRecord kMiss{100, kInvalidId, kInvalidId};
  const Scene scene_ = scene_of(
      {one_triangle({kAtZ0}), one_triangle({kAtZ0}), one_triangle({kAtZ2}), one_triangle({kHairBehindZ0})});
  const Oracle oracle_{scene_};
};

TEST_F(Judge, ClosestHits) {
  EXPECT_EQ(verdict(0.25f, {1, 0, 0}), Verdict::kAgrees);
  EXPECT_EQ(verdict(0.25f, {1, 1, 0}), Verdict::kAgrees);
  EXPECT_EQ(verdict(0.25f, {1, 3, 0}), Verdict::kTie);
  EXPECT_EQ(verdict(0.25f, {3, 2, 0}), Verdict::kWrongPrimitive);
  EXPECT_EQ(verdict(0.25f, kMiss), Verdict::kMissed);
  EXPECT_EQ(verdict(0.25f, {1, 0, 7}), Verdict::kFalseHit);
  EXPECT_EQ(verdict(-0.5f, kMiss), Verdict::kAgrees);
  EXPECT_EQ(verdict(-0.5f, {1, 0, 0}), Verdict::kFalseHit);
  EXPECT_EQ(verdict(0.0f, kMiss), Verdict::kWithinRounding);
  EXPECT_EQ(verdict(-1e-8f, {1, 0, 0}), Verdict::kWithinRounding);
}

TEST_F(Judge, Occlusion) {
  constexpr HitRecord kHit{0, 0, 0};
  EXPECT_EQ(verdict(0.25f, kHit, RayKind::kShadow), Verdict::kAgrees);
  EXPECT_EQ(verdict(0.25f, kMiss, RayKind::kShadow), Verdict::kMissed);
  EXPECT_EQ(verdict(-0.5f, kHit, RayKind::kShadow), Verdict::kFalseHit);
  EXPECT_EQ(verdict(0.0f, kMiss, RayKind::kShadow), Verdict::kWithinRounding);
}

TEST(ErrorCounts, PercentilesOfT) {
  EXPECT_EQ(percentile({}, 0.5), 0);
  EXPECT_EQ(percentile({1, 2, 3, 4, 5}, 0.5), 3);
  EXPECT_EQ(percentile({1, 2, 3, 4, 5}, 1), 5);
}

void expect_cull_changes_nothing(const Scene& scene, std::size_t count,
                                 std::string_view structure = "embree-robust") {
  const auto reference = build_structure(structure, scene, 0);
  const Oracle culled(scene);
  const Oracle all(scene, Oracle::Cull::kNone);
  for (RayKind kind : ray_kinds()) {
    const RaySet rays = make_rays(kind, scene, *reference, count, 3);
    const auto a = culled.answers(rays.rays);
    const auto b = all.answers(rays.rays);
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].is_hit, b[i].is_hit);
      ASSERT_EQ(a[i].t, b[i].t);
      ASSERT_EQ(a[i].nearest, b[i].nearest);
      ASSERT_EQ(a[i].u, b[i].u);
      ASSERT_EQ(a[i].v, b[i].v);
      ASSERT_EQ(a[i].ties, b[i].ties);
      ASSERT_EQ(a[i].is_possible, b[i].is_possible);
      ASSERT_EQ(a[i].certain_t_upper, b[i].certain_t_upper);
      ASSERT_EQ(a[i].is_near_edge, b[i].is_near_edge);
      ASSERT_EQ(a[i].edge_distance_ulps, b[i].edge_distance_ulps);
    }
  }
}

TEST(OracleCull, ChangesNothingInMixedSteps) {
  expect_cull_changes_nothing(mixed_step_scene(), 1000);
}

TEST(OracleCull, ChangesNothingInUnevenSteps) {
  expect_cull_changes_nothing(uneven_step_scene(), 1000, "stbvh-direct");
}

TEST(OracleCull, ChangesNothingInProceduralScenes) {
  for (const char* name : {"wheels", "crowd"}) {
    expect_cull_changes_nothing(find_procedural_scene(name)->make(0.01, 1), 50);
  }
}

}  // namespace
}  // namespace stbvh::harness
