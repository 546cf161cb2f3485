/// Rays that start so far away, or are so fast, that what traversal computes for boxes overflows or
/// underflows. Found by the fuzz targets.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "flush_to_zero.h"
#include "test_meshes.h"
#include "unculled.h"

namespace stbvh {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

/// Empty slots of nodes lead to the root: a ray that met one would never end.
TEST(FarRays, MeetNoEmptySlots) {
  constexpr float kFar[] = {1e19f, 1e21f, 1e25f, 1e30f, 1e38f, 3.4028234e38f};
  std::vector<test::TestMesh> meshes{test::soup(100, 1, 1), test::soup(100, 5, 2)};
  std::vector<MeshView> views;
  for (test::TestMesh& mesh : meshes) views.push_back(mesh.view());
  test::Random random(3);
  for (const Precision precision : {Precision::kWatertight, Precision::kFast}) {
    BuildSettings settings;
    settings.precision = precision;
    const auto structure = Structure::build(views, settings);
    for (int i = 0; i < test::count(5000); ++i) {
      const auto coordinate = [&] {
        const float far = kFar[random.bits() % std::size(kFar)];
        const std::uint32_t kind = random.bits() % 4;
        return kind == 0 ? random.unit() : kind == 1 ? far : -far;
      };
      const auto component = [&] { return static_cast<float>(random.bits() % 3) - 1.0f; };
      Ray ray{};
      ray.origin = {coordinate(), coordinate(), coordinate()};
      ray.direction = {component(), component(), component()};
      ray.tfar = kInf;
      ray.time = random.unit();
      ray.mask = 0xFFFFFFFFu;
      for (const Isa isa : available_isas()) {
        Hit hit;
        if (precision == Precision::kWatertight) {
          EXPECT_EQ(structure->intersect_on(isa, ray, hit), structure->occluded_on(isa, ray));
        } else {
          structure->intersect_on(isa, ray, hit);
          structure->occluded_on(isa, ray);
        }
      }
    }
  }
}

/// Edge functions that overflow say nothing: no hit may be taken for certain because of them. Boxes would
/// keep such rays out: the root is a leaf.
TEST(FarRays, AreOccludedByWhatTheyHit) {
  test::Random random(6);
  for (int i = 0; i < test::count(2000); ++i) {
    test::TestMesh mesh = test::soup(1, 1, random.bits());
    for (Vec3f& p : mesh.positions[0]) p = {1e13f * p.x, 1e13f * p.y, 1e13f * p.z};
    const MeshView view = mesh.view();
    const auto structure = Structure::build({&view, 1});
    // Aimed in y and z, from far aside.
    const Vec3f target = mesh.positions[0][random.bits() % 3];
    const Vec3f d = random.point(1.0f);
    const float aside = std::ldexp(random.between(-1, 1), 80 + static_cast<int>(random.bits() % 46));
    Ray ray{};
    ray.origin = {aside, target.y - 1e14f * d.y, target.z - 1e14f * d.z};
    ray.direction = {0.0f, d.y, d.z};
    ray.tfar = kInf;
    ray.mask = 0xFFFFFFFFu;
    for (const Isa isa : available_isas()) {
      Hit hit;
      ASSERT_EQ(structure->intersect_on(isa, ray, hit), structure->occluded_on(isa, ray)) << i;
    }
  }
}

/// Distances along the ray that are too small for float: t is zero, or a denormal number, or flushed to zero.
TEST(FarRays, FastRaysFindWhatIsHitAtNoTime) {
  test::TestMesh mesh = test::soup(40, 3, 4);
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  const test::Unculled unculled({&view, 1});
  test::Random random(5);
  int hits = 0;
  for (int i = 0; i < test::count(5000); ++i) {
    Ray ray = test::random_ray(random);
    const float length = std::ldexp(1.0f, 120 + static_cast<int>(random.bits() % 6));
    ray.direction = {length * ray.direction.x, length * ray.direction.y, length * ray.direction.z};
    constexpr float kEnds[] = {0.0f, 1e-45f, -1e-45f, 1e-38f, -1e-38f};
    ray.tnear = random.bits() % 2 == 0 ? -1.0f : kEnds[random.bits() % std::size(kEnds)];
    ray.tfar = random.bits() % 2 == 0 ? 1.0f : kEnds[random.bits() % std::size(kEnds)];
    for (const bool flush : {false, true}) {
      const test::FlushToZero guard(flush);
      for (const Isa isa : available_isas()) {
        Hit hit{};
        const auto expected = unculled.intersect(isa, ray);
        hits += expected.has_value();
        ASSERT_EQ(structure->intersect_on(isa, ray, hit), expected.has_value())
            << i << (flush ? " flushing" : "");
        ASSERT_EQ(structure->occluded_on(isa, ray), expected.has_value()) << i << (flush ? " flushing" : "");
        if (expected) {
          ASSERT_EQ(hit.t, expected->t);
        }
      }
    }
  }
  EXPECT_GT(hits, test::count(500));
}

}  // namespace
}  // namespace stbvh
