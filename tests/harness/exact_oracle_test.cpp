/// The oracle on cases whose answers are known on paper, to the last bit.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "harness/oracle/judge.h"
#include "harness/oracle/oracle.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

using Nearest = std::vector<OraclePrimitive>;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLeast = std::numeric_limits<float>::denorm_min();

float after(float x) {
  return std::nextafter(x, kInfinity);
}
float before(float x) {
  return std::nextafter(x, -kInfinity);
}

Mesh mesh_of(const std::vector<Vec3f>& points, const std::vector<std::uint32_t>& indices) {
  Mesh mesh;
  mesh.indices = indices;
  VertexBuffer& buffer = mesh.steps.emplace_back(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) buffer[i] = points[i];
  return mesh;
}

OracleAnswer answer(const Ray& ray, const std::vector<Mesh>& meshes) {
  Scene scene;
  scene.meshes = meshes;
  return Oracle(scene).answer(ray);
}

bool is_hit(const Ray& ray, const std::vector<Mesh>& meshes) {
  return answer(ray, meshes).is_hit;
}

/// The square of [0, size]^2 at z = 0: triangle 0 below its diagonal, triangle 1 above.
Mesh square(float size) {
  return mesh_of({{0, 0, 0}, {size, 0, 0}, {size, size, 0}, {0, size, 0}}, {0, 1, 2, 0, 2, 3});
}

TEST(ExactOracle, SharedEdgeBelongsToBothTriangles) {
  const Mesh mesh = square(1);
  EXPECT_EQ(answer(ray_along_z(0.3f, 0.3f), {mesh}).nearest, (Nearest{{0, 0}, {0, 1}}));
  EXPECT_EQ(answer(ray_along_z(after(0.3f), 0.3f), {mesh}).nearest, (Nearest{{0, 0}}));
  EXPECT_EQ(answer(ray_along_z(before(0.3f), 0.3f), {mesh}).nearest, (Nearest{{0, 1}}));
  EXPECT_EQ(answer(ray_along_z(0, 0), {mesh}).nearest, (Nearest{{0, 0}, {0, 1}}));
}

TEST(ExactOracle, OuterEdgeIsHitAndWhatLiesBesideItIsNot) {
  const Mesh mesh = square(1);
  EXPECT_TRUE(is_hit(ray_along_z(0, 0.5f), {mesh}));
  EXPECT_TRUE(is_hit(ray_along_z(kLeast, 0.5f), {mesh}));
  EXPECT_TRUE(is_hit(ray_along_z(1, 0.5f), {mesh}));
  EXPECT_FALSE(is_hit(ray_along_z(after(1), 0.5f), {mesh}));
  const OracleAnswer beside = answer(ray_along_z(-kLeast, 0.5f), {mesh});
  EXPECT_FALSE(beside.is_hit);
  EXPECT_TRUE(beside.nearest.empty());
  EXPECT_TRUE(beside.is_possible);
}

TEST(ExactOracle, VertexBelongsToAllItsTriangles) {
  const Mesh fan = mesh_of({{0.1f, 0.7f, 3}, {2, 0, 1}, {0, 2, 2}, {-2, 0, 5}, {0, -2, 4}},
                           {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1});
  EXPECT_EQ(answer(ray_along_z(0.1f, 0.7f), {fan}).nearest, (Nearest{{0, 0}, {0, 1}, {0, 2}, {0, 3}}));
  EXPECT_EQ(answer(ray_along_z(0.1f, 0.7f), {fan}).t, 4.0);
}

TEST(ExactOracle, EdgeThatNoFloatLiesOn) {
  // At x = 1 the edge from (0, 0) to (3, 1) is at y = 1/3, just below the float nearest to it.
  const Mesh mesh = one_triangle({{{{0, 0, 0}, {3, 1, 0}, {0, 1, 0}}}});
  const float third = 1.0f / 3.0f;
  EXPECT_TRUE(is_hit(ray_along_z(1, third), {mesh}));
  EXPECT_FALSE(is_hit(ray_along_z(1, before(third)), {mesh}));
}

TEST(ExactOracle, SlantedRayThroughAnEdge) {
  // From (-1, -2, -4) along (3, 5, 8): at t = 1/2 through (1/2, 1/2, 0), a point of the diagonal.
  Ray ray = ray_along_z(0, 0);
  ray.origin = {-1, -2, -4};
  ray.direction = {3, 5, 8};
  const OracleAnswer hit = answer(ray, {square(1)});
  EXPECT_EQ(hit.nearest, (Nearest{{0, 0}, {0, 1}}));
  EXPECT_EQ(hit.t, 0.5);
  ray.direction.x = after(3);
  EXPECT_EQ(answer(ray, {square(1)}).nearest, (Nearest{{0, 0}}));
}

TEST(ExactOracle, TrianglesWithoutAreaAreNeverHit) {
  EXPECT_FALSE(is_hit(ray_along_z(1, 1), {one_triangle({{{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}}})}));
  EXPECT_FALSE(is_hit(ray_along_z(1, 1), {one_triangle({{{{1, 1, 0}, {1, 1, 0}, {1, 1, 0}}}})}));
  EXPECT_FALSE(is_hit(ray_along_z(0.1f, 0.3f),
                      {one_triangle({{{{0, 0, 0}, {0.1f, 0.3f, 0.7f}, {0.2f, 0.6f, 1.4f}}}})}));
  // One corner crosses the opposite edge halfway through the shutter.
  const Mesh crossing =
      one_triangle({{{{0, 0, 0}, {2, 2, 0}, {0, 2, 0}}}, {{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}}}});
  EXPECT_TRUE(is_hit(ray_along_z(1, 1, 0.25f), {crossing}));
  EXPECT_FALSE(is_hit(ray_along_z(1, 1, 0.5f), {crossing}));
  EXPECT_TRUE(is_hit(ray_along_z(1, 1, after(0.5f)), {crossing}));
}

TEST(ExactOracle, TrianglesSeenFromTheSideAreNeverHit) {
  EXPECT_FALSE(is_hit(ray_along_z(0, 0), {one_triangle({{{{0, -1, 0}, {0, 1, 0}, {0, 0, 1}}}})}));
  // Corners at multiples of the direction (1, 2, 3) and (2, 2, 2) from the origin.
  Ray ray = ray_along_z(0, 0);
  ray.origin = {0, 0, 0};
  ray.direction = {0.1f, 0.2f, 0.3f};
  const Vec3f d = ray.direction;
  const Mesh side = one_triangle({{{{d.x + 1, 0.2f, 0.3f}, {d.x, d.y, d.z}, {2 * d.x, 2 * d.y, 2 * d.z}}}});
  EXPECT_FALSE(is_hit(ray, {side}));
}

TEST(ExactOracle, DuplicatesAndCoplanarTrianglesTie) {
  // Three different triangles of the plane z = x + y, one of them twice, and one a hair farther away.
  const Mesh a = one_triangle({{{{-1, -1, -2}, {3, 0, 3}, {0, 3, 3}}}});
  const Mesh b = one_triangle({{{{-2, 0, -2}, {5, -1, 4}, {1, 4, 5}}}});
  const Mesh c = one_triangle({{{{0, -3, -3}, {2, 7, 9}, {-4, 2, -2}}}});
  const Mesh farther = one_triangle({{{{-1, -1, after(-2)}, {3, 0, after(3)}, {0, 3, after(3)}}}});
  const OracleAnswer hit = answer(ray_along_z(0.1f, 0.2f), {farther, b, a, c, a});
  EXPECT_EQ(hit.nearest, (Nearest{{1, 0}, {2, 0}, {3, 0}, {4, 0}}));
  EXPECT_EQ(hit.t, 1 + static_cast<double>(0.1f) + static_cast<double>(0.2f));
  EXPECT_EQ(hit.geom_id, 1u);
  EXPECT_EQ(hit.ties, 4u);
  EXPECT_GE(hit.exact_triangles, 4u);
}

TEST(ExactOracle, BarycentricsAreEmbrees) {
  const Mesh mesh = one_triangle({{{{0, 0, 0}, {1, 0, 0}, {0, 3, 0}}}});
  const OracleAnswer hit = answer(ray_along_z(0.25f, 1), {mesh});
  EXPECT_EQ(hit.u, 0.25);
  EXPECT_EQ(hit.v, 1.0 / 3.0);
}

/// A mesh whose left edge is at x = |u - i| and which lies at z = |u - i|, u the time in segments.
Mesh around_step(std::size_t i, std::size_t segments) {
  Mesh mesh;
  mesh.indices = {0, 1, 2};
  for (std::size_t k = 0; k <= segments; ++k) {
    const float x = std::abs(static_cast<float>(k) - static_cast<float>(i));
    VertexBuffer& step = mesh.steps.emplace_back(3);
    step[0] = {x, -1, x};
    step[1] = {x + 4, 0, x};
    step[2] = {x, 1, x};
  }
  return mesh;
}

TEST(ExactOracle, TimesOfStepsThatFloatsMiss) {
  struct Case {
    std::size_t step, segments;
    float off;  ///< |S fl(i/S) - i| in units of 2^-26
  };
  // For instance fl(1/3) = 11184811 / 2^25, and 3 * 11184811 = 2^25 + 1. Those of 6, 11 and 29 lie before.
  constexpr Case kCases[] = {
      {1, 3, 2}, {2, 3, 4}, {1, 5, 1},  {2, 5, 2}, {3, 5, 8}, {4, 5, 4}, {1, 7, 3},  //
      {2, 7, 6}, {3, 7, 2}, {4, 7, 12}, {5, 7, 8}, {6, 7, 4}, {5, 6, 8}, {7, 11, 8}, {1, 29, 0.25f}};
  for (const Case& c : kCases) {
    const Mesh mesh = around_step(c.step, c.segments);
    const float time = static_cast<float>(c.step) / static_cast<float>(c.segments);
    const float off = c.off * 0x1p-26f;
    const OracleAnswer on_edge = answer(ray_along_z(off, 0, time), {mesh});
    EXPECT_TRUE(on_edge.is_hit) << c.step << "/" << c.segments;
    EXPECT_EQ(on_edge.t, 1.0 + static_cast<double>(off)) << c.step << "/" << c.segments;
    EXPECT_FALSE(is_hit(ray_along_z(before(off), 0, time), {mesh})) << c.step << "/" << c.segments;
  }
}

TEST(ExactOracle, OwnTimeRangeIsThatOfItsFloats) {
  // a = fl(0.1) = 13421773 / 2^27, b = fl(0.9) = 7549747 / 2^23: u = 3 (0.5 - a) / (b - a) = 53687091 /
  // 35791393.
  Mesh mesh = around_step(0, 3);
  mesh.time_range = {0.1f, 0.9f};
  EXPECT_EQ(answer(ray_along_z(2, 0, 0.5f), {mesh}).t, 1 + 53687091.0 / 35791393.0);
  EXPECT_EQ(answer(ray_along_z(2, 0, 0.1f), {mesh}).t, 1);
  EXPECT_EQ(answer(ray_along_z(3, 0, 0.9f), {mesh}).t, 4);
  EXPECT_FALSE(is_hit(ray_along_z(3, 0, after(0.9f)), {mesh}));
  EXPECT_FALSE(is_hit(ray_along_z(2, 0, before(0.1f)), {mesh}));
}

bool is_hit_within(float tnear, float tfar, float direction) {
  Ray ray = ray_along_z(0.5f, 0.25f);
  ray.direction.z = direction;
  ray.tnear = tnear;
  ray.tfar = tfar;
  return is_hit(ray, {square(1)});
}

TEST(ExactOracle, IntervalIsOpenAtTnearAndClosedAtTfar) {
  EXPECT_TRUE(is_hit_within(0, 1, 1));
  EXPECT_FALSE(is_hit_within(0, before(1), 1));
  EXPECT_FALSE(is_hit_within(1, 2, 1));
  EXPECT_TRUE(is_hit_within(before(1), 2, 1));
  EXPECT_TRUE(is_hit_within(-kInfinity, kInfinity, 1));
  EXPECT_FALSE(is_hit_within(kInfinity, kInfinity, 1));
  EXPECT_TRUE(is_hit_within(-1, -0.5f, -2));
  EXPECT_FALSE(is_hit_within(-0.5f, 0, -2));
  // t = 1/3 lies below its float, t = 1/25 above.
  const float third = 1.0f / 3.0f;
  EXPECT_TRUE(is_hit_within(0, third, 3));
  EXPECT_FALSE(is_hit_within(0, before(third), 3));
  EXPECT_FALSE(is_hit_within(third, 1, 3));
  EXPECT_TRUE(is_hit_within(before(third), 1, 3));
  const float twenty_fifth = 1.0f / 25.0f;
  EXPECT_FALSE(is_hit_within(0, twenty_fifth, 25));
  EXPECT_TRUE(is_hit_within(0, after(twenty_fifth), 25));
  EXPECT_TRUE(is_hit_within(twenty_fifth, 1, 25));
  EXPECT_FALSE(is_hit_within(after(twenty_fifth), 1, 25));
}

TEST(ExactOracle, IntervalAtZero) {
  Ray ray = ray_along_z(0.5f, 0.25f);
  ray.origin.z = 0;
  EXPECT_FALSE(is_hit(ray, {square(1)}));
  ray.tnear = -kLeast;
  ray.tfar = 0;
  EXPECT_TRUE(is_hit(ray, {square(1)}));
}

TEST(ExactOracle, AllScales) {
  for (const float scale : {0x1p-140f, 0x1p-66f, 1.0f, 0x1p50f, 0x1p60f}) {
    for (const float speed : {0x1p-66f, 1.0f, 0x1p66f}) {
      Ray ray = ray_along_z(0.3f, 0.3f);
      ray.origin = {0.25f * scale, 0.25f * scale, -scale};
      ray.direction.z = speed;
      ray.tfar = kInfinity;
      const OracleAnswer hit = answer(ray, {square(scale)});
      EXPECT_EQ(hit.nearest, (Nearest{{0, 0}, {0, 1}})) << scale;
      EXPECT_EQ(hit.t, static_cast<double>(scale) / static_cast<double>(speed));
      ray.origin.x = after(ray.origin.x);
      EXPECT_EQ(answer(ray, {square(scale)}).nearest, (Nearest{{0, 0}})) << scale;
      ray.origin.x = -kLeast;
      EXPECT_FALSE(is_hit(ray, {square(scale)})) << scale;
    }
  }
}

TEST(ExactOracle, DenormalCoordinates) {
  const Mesh mesh = one_triangle({{{{0, 0, 0}, {3 * kLeast, 0, 0}, {0, 3 * kLeast, 0}}}});
  EXPECT_TRUE(is_hit(ray_along_z(kLeast, kLeast), {mesh}));
  EXPECT_TRUE(is_hit(ray_along_z(kLeast, 2 * kLeast), {mesh}));
  EXPECT_FALSE(is_hit(ray_along_z(2 * kLeast, 2 * kLeast), {mesh}));
  EXPECT_EQ(answer(ray_along_z(kLeast, kLeast), {mesh}).u, 1.0 / 3.0);
}

TEST(ExactOracle, NeedlesFarFromTheOrigin) {
  // 8192 long and half a unit wide; halfway along, its edges are at y = 1/4 and 1/2.
  constexpr float kFar = 0x1p20f;
  const Mesh mesh = one_triangle({{{{kFar, 0, kFar}, {kFar + 8192, 1, kFar}, {kFar + 8192, 0.5f, kFar}}}});
  const auto at = [](float y) {
    Ray ray = ray_along_z(kFar + 4096, y);
    ray.tfar = kInfinity;
    return ray;
  };
  EXPECT_TRUE(is_hit(at(0.25f), {mesh}));
  EXPECT_TRUE(is_hit(at(0.5f), {mesh}));
  EXPECT_FALSE(is_hit(at(before(0.25f)), {mesh}));
  EXPECT_FALSE(is_hit(at(after(0.5f)), {mesh}));
  EXPECT_EQ(answer(at(0.3f), {mesh}).t, 0x1p20 + 1);
}

TEST(ExactOracle, FarOriginsAndLargeVertices) {
  Ray ray = ray_along_z(0.25f, 0.25f);
  ray.origin.z = -0x1p100f;
  ray.tfar = kInfinity;
  EXPECT_EQ(answer(ray, {square(1)}).nearest, (Nearest{{0, 0}, {0, 1}}));
  EXPECT_EQ(answer(ray, {square(1)}).t, 0x1p100);
  ray.origin.x = -kLeast;
  EXPECT_FALSE(is_hit(ray, {square(1)}));
}

TEST(ExactOracle, RaysThatAreNoRaysHitNothing) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  std::vector<Ray> rays(7, ray_along_z(0.5f, 0.25f));
  rays[0].origin.x = kNaN;
  rays[1].origin.z = -kInfinity;
  rays[2].direction = {0, 0, 0};
  rays[3].direction.z = kInfinity;
  rays[4].time = kNaN;
  rays[5].tnear = kNaN;
  rays[6].tfar = kNaN;
  Scene scene;
  scene.meshes = {square(1)};
  const Oracle oracle(scene);
  for (const Ray& ray : rays) {
    EXPECT_FALSE(oracle.answer(ray).is_possible);
    EXPECT_FALSE(oracle.test(ray, 0, 0).has_value());
  }
}

TEST(ExactOracle, OrdinaryRaysAreDecidedInDouble) {
  const Scene scene = mixed_step_scene();
  Pcg32 random(5);
  std::vector<Ray> rays;
  for (int i = 0; i < 5000; ++i) {
    Ray ray = ray_along_z(static_cast<float>(random.uniform(0, 10)),
                          static_cast<float>(random.uniform(0, 10)), static_cast<float>(random.uniform()));
    ray.direction.x = static_cast<float>(random.uniform(-0.2, 0.2));
    rays.push_back(ray);
  }
  std::size_t hits = 0;
  std::size_t exact = 0;
  for (const OracleAnswer& a : Oracle(scene).answers(rays)) {
    hits += a.nearest.size();
    exact += a.exact_triangles;
  }
  EXPECT_GT(hits, 1000u);
  EXPECT_LE(exact, 5u);
}

TEST(ExactJudge, AnyOfTheNearestIsRight) {
  Scene scene;
  scene.meshes = {square(1), square(1)};
  const Oracle oracle(scene);
  const RaySet rays{RayKind::kPrimary, {ray_along_z(0.25f, 0.25f)}};
  const auto answers = oracle.answers(rays.rays);
  for (const std::uint32_t geom_id : {0u, 1u}) {
    for (const std::uint32_t prim_id : {0u, 1u}) {
      const HitRecord hit{1, geom_id, prim_id};
      const ErrorCounts counts = judge(oracle, 1.0, rays, answers, std::span(&hit, 1));
      EXPECT_EQ(counts.ties, 0u);
      EXPECT_TRUE(counts.differences.empty());
    }
  }
}

}  // namespace
}  // namespace stbvh::harness
