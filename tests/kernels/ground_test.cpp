/// Distances from large triangles: a ray that leaves a plane does not meet it, however large it is.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "flush_to_zero.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

/// Component `axis` + 1, + 2, + 3 (modulo 3) of a vector.
Vec3f on_axes(int axis, float right, float forward, float up) {
  float p[3];
  p[(axis + 1) % 3] = right;
  p[(axis + 2) % 3] = forward;
  p[axis] = up;
  return {p[0], p[1], p[2]};
}

/// Two triangles over [-size, size]^2 across `axis`, at `height`; `slide` is their way along themselves.
test::TestMesh ground(int axis, float size, float height, std::size_t steps, float slide) {
  test::TestMesh mesh;
  mesh.indices = {0, 1, 2, 0, 2, 3};
  for (std::size_t k = 0; k < steps; ++k) {
    const float way = slide * static_cast<float>(k);
    mesh.positions.push_back(
        {on_axes(axis, way - size, way - size, height), on_axes(axis, way + size, way - size, height),
         on_axes(axis, way + size, way + size, height), on_axes(axis, way - size, way + size, height)});
  }
  return mesh;
}

Ray ray_from(Vec3f origin, Vec3f direction, test::Random& random) {
  Ray ray{};
  ray.origin = origin;
  ray.direction = direction;
  ray.tfar = kInf;
  ray.time = random.unit();
  ray.mask = 0xFFFFFFFFu;
  return ray;
}

class GroundOnIsa : public testing::TestWithParam<std::tuple<Isa, bool>> {};

INSTANTIATE_TEST_SUITE_P(IsasAndFlushToZero, GroundOnIsa,
                         testing::Combine(testing::ValuesIn(available_isas()), testing::Bool()),
                         [](const auto& param_info) {
                           return std::string(isa_name(std::get<0>(param_info.param))) +
                                  (std::get<1>(param_info.param) ? "_ftz" : "");
                         });

/// Rays that leave it: from itself, and from a little above or below on their way off.
TEST_P(GroundOnIsa, IsNotMetByRaysThatLeaveIt) {
  const auto [isa, flush] = GetParam();
  const test::FlushToZero guard(flush);
  test::Random random(1);
  for (const float size : {10.0f, 1e3f, 1e4f, 1e5f, 1e6f, 1e10f, 1e15f}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::size_t steps : {1u, 2u, 5u}) {
        for (const float slide : {0.0f, 0.01f * size}) {
          test::TestMesh mesh = ground(axis, size, 0, steps, slide);
          const MeshView view = mesh.view();
          const auto structure = Structure::build({&view, 1});
          for (int i = 0; i < test::count(400); ++i) {
            constexpr float kHeights[] = {0, 1e-4f, 1e-3f, 1e-2f};
            const float sign = i % 2 == 0 ? 1.0f : -1.0f;
            const Vec3f across = random.point(0.9f * size);
            const Vec3f d = random.point(1.0f);
            const float up = i % 8 < 4 ? std::fabs(d.z) + 1e-6f : 1e-6f;
            const Ray ray = ray_from(on_axes(axis, across.x, across.y, sign * kHeights[i / 8 % 4]),
                                     on_axes(axis, d.x, d.y, sign * up), random);
            Hit hit;
            ASSERT_FALSE(structure->intersect_on(isa, ray, hit)) << size << " " << axis << " t " << hit.t;
            ASSERT_FALSE(structure->occluded_on(isa, ray));
          }
        }
      }
    }
  }
}

/// The other way round: the distance is exact to a float's rounding, however large the ground.
TEST_P(GroundOnIsa, IsMetAtItsExactDistance) {
  const auto [isa, flush] = GetParam();
  const test::FlushToZero guard(flush);
  test::Random random(2);
  for (const float size : {1e3f, 1e4f, 1e6f, 1e15f}) {
    for (int axis = 0; axis < 3; ++axis) {
      test::TestMesh mesh = ground(axis, size, 0.75f, 3, 0.001f * size);
      const MeshView view = mesh.view();
      const auto structure = Structure::build({&view, 1});
      for (int i = 0; i < test::count(1000); ++i) {
        const float height = 0.75f + random.between(1e-3f, 1.0f);
        const Vec3f across = random.point(0.5f * size);
        const Vec3f d = random.point(1.0f);
        const float down = -std::fabs(d.z) - 0.01f;
        const Ray ray =
            ray_from(on_axes(axis, across.x, across.y, height), on_axes(axis, d.x, d.y, down), random);
        Hit hit;
        ASSERT_TRUE(structure->intersect_on(isa, ray, hit));
        const double exact = (0.75 - static_cast<double>(height)) / down;
        ASSERT_NEAR(hit.t, exact, 0x1.001p-24 * exact);
      }
    }
  }
}

/// From a point of a turned plane, rounded to float, half of all rays would meet it again.
TEST_P(GroundOnIsa, IsNotMetFromItsOwnRoundedPoints) {
  const auto [isa, flush] = GetParam();
  const test::FlushToZero guard(flush);
  test::Random random(3);
  for (const float size : {1.0f, 1e3f, 1e6f}) {
    int again = 0, rays = 0;
    for (int mesh_number = 0; mesh_number < 20; ++mesh_number) {
      test::TestMesh mesh;
      mesh.indices = {0, 1, 2};
      mesh.positions = {{random.point(size), random.point(size), random.point(size)}};
      const MeshView view = mesh.view();
      const auto structure = Structure::build({&view, 1});
      const std::vector<Vec3f>& p = mesh.positions[0];
      for (int i = 0; i < test::count(200); ++i) {
        double u = random.unit(), v = random.unit();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto weighted = [&](float a, float b, float c) {
          return static_cast<float>((1 - u - v) * a + u * b + v * c);
        };
        const Ray ray = ray_from({weighted(p[0].x, p[1].x, p[2].x), weighted(p[0].y, p[1].y, p[2].y),
                                  weighted(p[0].z, p[1].z, p[2].z)},
                                 random.point(1.0f), random);
        Hit hit;
        again += structure->intersect_on(isa, ray, hit);
        ++rays;
        ASSERT_EQ(structure->occluded_on(isa, ray), structure->intersect_on(isa, ray, hit));
      }
    }
    EXPECT_EQ(again, 0) << "of " << rays << ", size " << size;
  }
}

/// A triangle ahead of an origin that lies in its plane is met all the same, and so is a ray's way back.
TEST_P(GroundOnIsa, IsMetFromNearItsPlaneWhereItLiesAhead) {
  const auto [isa, flush] = GetParam();
  const test::FlushToZero guard(flush);
  test::TestMesh mesh;
  mesh.indices = {0, 1, 2};
  mesh.positions = {{{2, 1, -1}, {4, 1, -1}, {3, 1, 1}}};
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  test::Random random(4);
  Hit hit;
  Ray ray = ray_from({0, std::nextafter(1.0f, 2.0f), 0}, {1, -0x1p-23f / 3, 0}, random);
  ASSERT_TRUE(structure->intersect_on(isa, ray, hit));
  EXPECT_GE(hit.t, 2.0f);
  EXPECT_LE(hit.t, 4.0f);
  EXPECT_TRUE(structure->occluded_on(isa, ray));
}

}  // namespace
}  // namespace stbvh
