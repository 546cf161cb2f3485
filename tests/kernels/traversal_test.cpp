#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "limited.h"
#include "stbvh/structure.h"
#include "test_meshes.h"
#include "unculled.h"

namespace stbvh {
namespace {

using test::Random;
using test::TestMesh;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<TestMesh> mixed_meshes() {
  std::vector<TestMesh> meshes;
  meshes.push_back(test::soup(120, 9, 11));
  meshes.push_back(test::soup(80, 1, 12));
  meshes.push_back(test::soup(60, 4, 13));
  meshes.push_back(test::sphere(8, 6));
  meshes[2].time_range = {0.3f, 0.8f};
  for (std::size_t i = 0; i < meshes.size(); ++i) meshes[i].geom_id = 10 + static_cast<std::uint32_t>(i);
  return meshes;
}

std::vector<MeshView> views(std::vector<TestMesh>& meshes) {
  std::vector<MeshView> v;
  for (TestMesh& mesh : meshes) v.push_back(mesh.view());
  return v;
}

class TraversalOnIsa : public testing::TestWithParam<Isa> {};

INSTANTIATE_TEST_SUITE_P(Isas, TraversalOnIsa, testing::ValuesIn(available_isas()),
                         [](const auto& param_info) { return std::string(isa_name(param_info.param)); });

TEST_P(TraversalOnIsa, FindsWhatTheTriangleTestAccepts) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const std::vector<MeshView> v = views(meshes);
  for (const float share : {1.0f, 0.0f, 0.5f}) {
    const auto structure = Structure::build(v, test::limited(v, share));
    const test::Unculled unculled(v);
    Random random(7);
    int hits = 0;
    for (int i = 0; i < test::count(3000); ++i) {
      Ray ray = test::random_ray(random);
      if (i % 5 == 0) ray.direction.x = 0.0f;
      if (i % 7 == 0) ray.direction.y = -0.0f;
      if (i % 11 == 0) ray.time = static_cast<float>(i % 9) / 8.0f;
      Hit hit;
      const bool found = structure->intersect_on(GetParam(), ray, hit);
      const std::optional<Hit> expected = unculled.intersect(GetParam(), ray);
      ASSERT_EQ(found, expected.has_value()) << "ray " << i;
      ASSERT_EQ(structure->occluded_on(GetParam(), ray), found);
      if (!found) continue;
      ++hits;
      EXPECT_EQ(hit.t, expected->t);
      EXPECT_EQ(hit.prim_id, expected->prim_id);
      EXPECT_EQ(hit.geom_id, expected->geom_id);
      EXPECT_EQ(hit.u, expected->u);
      EXPECT_EQ(hit.v, expected->v);
    }
    EXPECT_GT(hits, test::count(1000));
  }
}

TEST_P(TraversalOnIsa, HitDataDescribeThePointOnTheTriangle) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const auto structure = Structure::build(views(meshes));
  Random random(8);
  for (int i = 0; i < test::count(2000); ++i) {
    const Ray ray = test::random_ray(random);
    Hit hit;
    if (!structure->intersect_on(GetParam(), ray, hit)) continue;
    const TestMesh& mesh = meshes[hit.mesh];
    EXPECT_EQ(hit.geom_id, mesh.geom_id);
    const double segments = static_cast<double>(mesh.positions.size() - 1);
    const double length = static_cast<double>(mesh.time_range.end) - mesh.time_range.begin;
    const double u =
        segments == 0 ? 0 : (static_cast<double>(ray.time) - mesh.time_range.begin) / length * segments;
    const auto k = static_cast<std::size_t>(std::min(u, segments - 1 + (segments == 0)));
    const double f = u - static_cast<double>(k);
    double p[3][3];
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.indices[3 * hit.prim_id + corner];
      const Vec3f& a = mesh.positions[k][vertex];
      const Vec3f& b = segments == 0 ? a : mesh.positions[k + 1][vertex];
      p[corner][0] = (1 - f) * a.x + f * b.x;
      p[corner][1] = (1 - f) * a.y + f * b.y;
      p[corner][2] = (1 - f) * a.z + f * b.z;
    }
    const double w = 1.0 - hit.u - hit.v;
    const float o[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
    const float d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
    double e1[3], e2[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double on_triangle = w * p[0][axis] + hit.u * p[1][axis] + hit.v * p[2][axis];
      EXPECT_NEAR(on_triangle, o[axis] + static_cast<double>(hit.t) * d[axis], 2e-5);
      e1[axis] = p[1][axis] - p[0][axis];
      e2[axis] = p[2][axis] - p[0][axis];
    }
    EXPECT_NEAR(hit.normal.x, e1[1] * e2[2] - e1[2] * e2[1], 1e-5);
    EXPECT_NEAR(hit.normal.y, e1[2] * e2[0] - e1[0] * e2[2], 1e-5);
    EXPECT_NEAR(hit.normal.z, e1[0] * e2[1] - e1[1] * e2[0], 1e-5);
  }
}

TEST_P(TraversalOnIsa, TnearIsOpenAndTfarClosed) {
  TestMesh mesh;
  mesh.indices = {0, 1, 2};
  mesh.positions = {{{0, 0, 2}, {1, 0, 2}, {0, 1, 2}}};
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  Hit hit;
  const auto hits = [&](float tnear, float tfar) {
    const Ray ray{{0.25f, 0.25f, 0}, tnear, {0, 0, 1}, 0.5f, tfar, 1};
    return structure->intersect_on(GetParam(), ray, hit);
  };
  EXPECT_TRUE(hits(0, 2));
  EXPECT_FALSE(hits(0, std::nextafter(2.0f, 0.0f)));
  EXPECT_FALSE(hits(2, 3));
  EXPECT_TRUE(hits(std::nextafter(2.0f, 0.0f), 2));
  EXPECT_FALSE(hits(2, 2));
  EXPECT_FALSE(hits(3, 1));
  EXPECT_FALSE(hits(kNan, 3));
  EXPECT_FALSE(hits(0, kNan));
  EXPECT_TRUE(hits(-1, kInf));
}

TEST_P(TraversalOnIsa, RaysThatAreNotFiniteHitNothing) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const auto structure = Structure::build(views(meshes));
  Random random(9);
  for (int i = 0; i < test::count(200); ++i) {
    for (const float bad : {kNan, kInf, -kInf}) {
      for (int what = 0; what < 7; ++what) {
        Ray ray = test::random_ray(random);
        float* fields[] = {&ray.origin.x,    &ray.origin.y,    &ray.origin.z, &ray.direction.x,
                           &ray.direction.y, &ray.direction.z, &ray.time};
        *fields[what] = bad;
        Hit hit;
        EXPECT_FALSE(structure->intersect_on(GetParam(), ray, hit));
        EXPECT_FALSE(structure->occluded_on(GetParam(), ray));
      }
    }
    Ray ray = test::random_ray(random);
    Hit hit;
    for (const float time : {-1e-6f, std::nextafter(1.0f, 2.0f), 1e20f}) {
      ray.time = time;
      EXPECT_FALSE(structure->intersect_on(GetParam(), ray, hit));
    }
    ray = test::random_ray(random);
    ray.direction = {0, -0.0f, 0};
    EXPECT_FALSE(structure->intersect_on(GetParam(), ray, hit));
  }
}

TEST_P(TraversalOnIsa, DirectionsOfAnyLength) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const auto structure = Structure::build(views(meshes));
  Random random(10);
  for (int i = 0; i < test::count(500); ++i) {
    const Ray ray = test::random_ray(random);
    Hit expected{}, hit{};
    const bool found = structure->intersect_on(GetParam(), ray, expected);
    for (const float scale : {0x1p-66f, 0x1p-20f, 0x1p30f, 0x1p66f}) {
      Ray scaled = ray;
      scaled.direction = {ray.direction.x * scale, ray.direction.y * scale, ray.direction.z * scale};
      ASSERT_EQ(structure->intersect_on(GetParam(), scaled, hit), found);
      if (found) {
        EXPECT_EQ(hit.t, expected.t / scale);
        EXPECT_EQ(hit.prim_id, expected.prim_id);
      }
    }
  }
}

TEST_P(TraversalOnIsa, MasksAndTimeRangesOfMeshes) {
  std::vector<TestMesh> meshes = mixed_meshes();
  for (std::size_t i = 0; i < meshes.size(); ++i) meshes[i].mask = 1u << i;
  const auto structure = Structure::build(views(meshes));
  Random random(11);
  int seen[4] = {};
  for (int i = 0; i < test::count(8000); ++i) {
    Ray ray = test::random_ray(random);
    ray.mask = random.bits() & 15;
    Hit hit;
    if (!structure->intersect_on(GetParam(), ray, hit)) continue;
    EXPECT_NE(meshes[hit.mesh].mask & ray.mask, 0u);
    const TimeRange range = meshes[hit.mesh].time_range;
    EXPECT_GE(ray.time, range.begin);
    EXPECT_LE(ray.time, range.end);
    ++seen[hit.mesh];
  }
  for (const int count : seen) EXPECT_GT(count, test::count(50));
}

TEST_P(TraversalOnIsa, FiltersSeeEveryCandidateAndMayReject) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const std::vector<MeshView> v = views(meshes);
  const auto structure = Structure::build(v);
  struct Seen {
    std::vector<Hit> rejected;
  };
  Random random(12);
  for (int i = 0; i < test::count(1000); ++i) {
    const Ray ray = test::random_ray(random);
    // Reject odd primitives: what remains must be the nearest even one, as in a scene without the odd ones.
    const HitFilter even{[](void*, const Ray&, const Hit& hit) { return hit.prim_id % 2 == 0; }, nullptr};
    Seen seen;
    const HitFilter none{[](void* user, const Ray& r, const Hit& hit) {
                           EXPECT_GT(hit.t, r.tnear);
                           static_cast<Seen*>(user)->rejected.push_back(hit);
                           return false;
                         },
                         &seen};
    Hit hit;
    EXPECT_FALSE(structure->intersect_on(GetParam(), ray, hit, &none));
    const Hit* nearest_even = nullptr;
    for (const Hit& candidate : seen.rejected) {
      if (candidate.prim_id % 2 == 0 && (nearest_even == nullptr || candidate.t < nearest_even->t)) {
        nearest_even = &candidate;
      }
    }
    ASSERT_EQ(structure->intersect_on(GetParam(), ray, hit, &even), nearest_even != nullptr);
    if (nearest_even != nullptr) {
      EXPECT_EQ(hit.t, nearest_even->t);
    }
    EXPECT_EQ(structure->occluded_on(GetParam(), ray, &even), nearest_even != nullptr);
  }
}

TEST(Traversal, CountersCountWhatIsVisited) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const auto structure = Structure::build(views(meshes));
  Random random(13);
  TraversalCounters counters;
  for (int i = 0; i < test::count(100); ++i) {
    const Ray ray = test::random_ray(random);
    Hit hit, plain;
    const bool found = structure->intersect_counted(ray, hit, counters);
    ASSERT_EQ(structure->intersect(ray, plain), found);
    EXPECT_EQ(structure->occluded_counted(ray, counters), found);
  }
  EXPECT_GE(counters.nodes, 2u * test::count(100));
  EXPECT_GT(counters.leaves, 0u);
  EXPECT_GE(counters.triangle_tests, counters.leaves);
}

}  // namespace
}  // namespace stbvh
