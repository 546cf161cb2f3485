// The precision kFast: the same tree and the same hits, but for rays near edges.
#include <gtest/gtest.h>

#include <cmath>

#include "limited.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

using test::Random;
using test::TestMesh;

struct Both {
  std::unique_ptr<Structure> watertight, fast;
};

Both build_both(std::vector<TestMesh>& meshes, float share) {
  std::vector<MeshView> views;
  for (std::uint32_t i = 0; i < meshes.size(); ++i) {
    meshes[i].geom_id = i;
    views.push_back(meshes[i].view());
  }
  BuildSettings settings = test::limited(views, share);
  Both both{Structure::build(views, settings), nullptr};
  settings.precision = Precision::kFast;
  both.fast = Structure::build(views, settings);
  return both;
}

std::vector<TestMesh> meshes() {
  std::vector<TestMesh> meshes;
  meshes.push_back(test::soup(300, 9, 11));
  meshes.push_back(test::soup(200, 1, 12));
  meshes.push_back(test::sphere(12, 6));
  return meshes;
}

class FastOnIsa : public testing::TestWithParam<Isa> {};

INSTANTIATE_TEST_SUITE_P(Isas, FastOnIsa, testing::ValuesIn(available_isas()),
                         [](const auto& param_info) { return std::string(isa_name(param_info.param)); });

TEST_P(FastOnIsa, HitsAsTheWatertightTestButForEdges) {
  std::vector<TestMesh> scene = meshes();
  for (const float share : {1.0f, 0.0f}) {
    const Both both = build_both(scene, share);
    EXPECT_EQ(both.fast->tree_hash(), both.watertight->tree_hash());
    Random random(5);
    int hits = 0, different = 0;
    for (int i = 0; i < test::count(20000); ++i) {
      const Ray ray = test::random_ray(random);
      Hit fast{}, exact{};
      const bool is_hit = both.fast->intersect_on(GetParam(), ray, fast);
      EXPECT_EQ(both.fast->occluded_on(GetParam(), ray), is_hit);
      hits += is_hit;
      if (both.watertight->intersect_on(GetParam(), ray, exact) != is_hit ||
          (is_hit && (fast.geom_id != exact.geom_id || fast.prim_id != exact.prim_id))) {
        ++different;
        continue;
      }
      if (!is_hit) continue;
      EXPECT_NEAR(fast.t, exact.t, 1e-3f * exact.t);
      EXPECT_NEAR(fast.u, exact.u, 2e-2f);
      EXPECT_NEAR(fast.v, exact.v, 2e-2f);
      const float scale = std::fabs(exact.normal.x) + std::fabs(exact.normal.y) + std::fabs(exact.normal.z);
      EXPECT_NEAR(fast.normal.x, exact.normal.x, 1e-3f * scale);
      EXPECT_NEAR(fast.normal.y, exact.normal.y, 1e-3f * scale);
      EXPECT_NEAR(fast.normal.z, exact.normal.z, 1e-3f * scale);
    }
    EXPECT_GT(hits, test::count(5000));
    EXPECT_LE(different, test::count(20000) / 1000 + 1);
  }
}

TEST_P(FastOnIsa, FiltersMayRejectEveryHit) {
  std::vector<TestMesh> scene = meshes();
  const Both both = build_both(scene, kMaxSteps);
  int asked = 0;
  const HitFilter none{[](void* user, const Ray&, const Hit&) { return ++*static_cast<int*>(user) < 0; },
                       &asked};
  Random random(6);
  for (int i = 0; i < test::count(500); ++i) {
    const Ray ray = test::random_ray(random);
    Hit hit;
    EXPECT_FALSE(both.fast->intersect_on(GetParam(), ray, hit, &none));
    EXPECT_FALSE(both.fast->occluded_on(GetParam(), ray, &none));
  }
  EXPECT_GT(asked, test::count(500));
}

TEST_P(FastOnIsa, RaysThatAreNotFiniteHitNothing) {
  std::vector<TestMesh> scene = meshes();
  const Both both = build_both(scene, kMaxSteps);
  constexpr float kBad[] = {NAN, INFINITY, -INFINITY};
  Random random(7);
  for (const float bad : kBad) {
    for (int member = 0; member < 7; ++member) {
      Ray ray = test::random_ray(random);
      float* const members[] = {&ray.origin.x,    &ray.origin.y,    &ray.origin.z, &ray.direction.x,
                                &ray.direction.y, &ray.direction.z, &ray.time};
      *members[member] = bad;
      Hit hit;
      EXPECT_FALSE(both.fast->intersect_on(GetParam(), ray, hit)) << member;
      EXPECT_FALSE(both.fast->occluded_on(GetParam(), ray)) << member;
    }
  }
}

}  // namespace
}  // namespace stbvh
