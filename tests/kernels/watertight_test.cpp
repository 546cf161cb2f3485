#include <gtest/gtest.h>

#include "flush_to_zero.h"
#include "limited.h"
#include "stbvh/structure.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

using test::FlushToZero;
using test::Random;
using test::TestMesh;

/// Position of a vertex at `time`, close enough to aim at.
Vec3f at(const TestMesh& mesh, std::uint32_t vertex, float time) {
  const auto segments = static_cast<float>(mesh.positions.size() - 1);
  const float u = time * segments;
  const auto k = static_cast<std::size_t>(std::min(std::floor(u), segments - 1));
  const float f = u - static_cast<float>(k);
  const Vec3f& a = mesh.positions[k][vertex];
  const Vec3f& b = mesh.positions[k + 1][vertex];
  return {(1 - f) * a.x + f * b.x, (1 - f) * a.y + f * b.y, (1 - f) * a.z + f * b.z};
}

/// Rays from near the centre of a closed moving sphere at its vertices and at points of its edges: all must
/// hit.
std::size_t count_leaks(const Structure& structure, const TestMesh& mesh, Isa isa, Vec3f centre, int rays) {
  Random random(21);
  std::size_t leaks = 0;
  const auto segments = static_cast<float>(mesh.positions.size() - 1);
  for (int i = 0; i < rays; ++i) {
    float time = random.unit();
    if (i % 4 == 0) time = std::floor(time * segments) / segments;
    const std::size_t triangle = random.bits() % (mesh.indices.size() / 3);
    const Vec3f a = at(mesh, mesh.indices[3 * triangle], time);
    const Vec3f b = at(mesh, mesh.indices[3 * triangle + 1], time);
    const float s = i % 2 == 0 ? 0.0f : random.unit();
    const Vec3f target{(1 - s) * a.x + s * b.x, (1 - s) * a.y + s * b.y, (1 - s) * a.z + s * b.z};
    const Vec3f middle = test::tumble(centre, time);
    Ray ray{};
    ray.origin = {middle.x + random.between(-0.2f, 0.2f), middle.y + random.between(-0.2f, 0.2f), middle.z};
    ray.direction = {target.x - ray.origin.x, target.y - ray.origin.y, target.z - ray.origin.z};
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.time = time;
    ray.mask = 1;
    Hit hit;
    leaks += !structure.intersect_on(isa, ray, hit);
    leaks += !structure.occluded_on(isa, ray);
  }
  return leaks;
}

class WatertightOnIsa : public testing::TestWithParam<std::tuple<Isa, bool>> {};

INSTANTIATE_TEST_SUITE_P(IsasAndFlushToZero, WatertightOnIsa,
                         testing::Combine(testing::ValuesIn(available_isas()), testing::Bool()),
                         [](const auto& param_info) {
                           return std::string(isa_name(std::get<0>(param_info.param))) +
                                  (std::get<1>(param_info.param) ? "_ftz" : "");
                         });

TEST_P(WatertightOnIsa, ClosedMovingSphereAtVerticesAndEdges) {
  const auto [isa, flush] = GetParam();
  for (const std::size_t steps : {2u, 3u, 9u, 129u}) {
    TestMesh mesh = test::sphere(24, steps);
    const MeshView view = mesh.view();
    for (const float share : {1.0f, 0.0f}) {
      const auto structure = Structure::build({&view, 1}, test::limited({&view, 1}, share));
      const FlushToZero guard(flush);
      EXPECT_EQ(count_leaks(*structure, mesh, isa, {0, 0, 0}, test::count(10000)), 0u) << steps << " steps";
    }
  }
}

TEST_P(WatertightOnIsa, SameHitsOnEveryIsaAndLayout) {
  const auto [isa, flush] = GetParam();
  TestMesh mesh = test::sphere(24, 9);
  const MeshView view = mesh.view();
  const auto a = Structure::build({&view, 1});
  const auto b = Structure::build({&view, 1}, test::limited({&view, 1}, 0.0f));
  const FlushToZero guard(flush);
  Random random(22);
  for (int i = 0; i < test::count(20000); ++i) {
    const Ray ray = test::random_ray(random);
    Hit p{}, q{};
    const bool found = a->intersect_on(Isa::kScalar, ray, p);
    ASSERT_EQ(b->intersect_on(isa, ray, q), found);
    if (!found) continue;
    EXPECT_EQ(p.t, q.t);
    EXPECT_EQ(p.prim_id, q.prim_id);
    EXPECT_EQ(p.u, q.u);
    EXPECT_EQ(p.normal.x, q.normal.x);
  }
}

}  // namespace
}  // namespace stbvh
