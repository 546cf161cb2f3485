// Many rays in a call: the answers of one ray at a time, bit for bit, whatever is in flight beside it.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>

#include "limited.h"
#include "stbvh/structure.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

using test::Random;
using test::TestMesh;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class BatchOnIsa : public testing::TestWithParam<Isa> {
 protected:
  static std::unique_ptr<Structure> build(float share, const BuildSettings& settings) {
    static std::vector<TestMesh> meshes = [] {
      std::vector<TestMesh> made{test::soup(120, 9, 11), test::soup(80, 1, 12), test::soup(60, 4, 13),
                                 test::sphere(8, 6)};
      made[1].mask = 2;
      made[2].time_range = {0.3f, 0.8f};
      return made;
    }();
    std::vector<MeshView> views;
    for (TestMesh& mesh : meshes) views.push_back(mesh.view());
    return Structure::build(views, test::limited(views, share, settings));
  }
};

INSTANTIATE_TEST_SUITE_P(Isas, BatchOnIsa, testing::ValuesIn(available_isas()),
                         [](const auto& param_info) { return std::string(isa_name(param_info.param)); });

/// Also rays that end at once, that hit nothing whatever is there, and some of another mask.
std::vector<Ray> unlike_rays(std::size_t count, std::uint32_t seed) {
  Random random(seed);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Ray ray = test::random_ray(random);
    if (i % 5 == 1) ray.mask = 2;
    if (i % 7 == 2) ray.direction = {0, 0, 0};
    if (i % 11 == 3) ray.time = kNan;
    if (i % 13 == 4) ray.tfar = ray.tnear;
    rays.push_back(ray);
  }
  return rays;
}

/// Rays with something behind each, which nobody may touch.
struct Spaced {
  Ray ray;
  std::uint32_t beside[3];
};

struct Found {
  const Spaced* first;
  std::vector<int> times;
  std::vector<Hit> hits;

  std::size_t count(const Ray& ray) {
    const auto i = static_cast<std::size_t>(reinterpret_cast<const Spaced*>(&ray) - first);
    ++times.at(i);
    return i;
  }
  static void closest_hit(void* user, const Ray& ray, const Hit& hit) {
    auto& found = *static_cast<Found*>(user);
    found.hits[found.count(ray)] = hit;
  }
  static void any_hit(void* user, const Ray& ray, const Hit&) { static_cast<Found*>(user)->count(ray); }
};

/// Each candidate is taken or not by its ray and itself alone, so that the order of rays does not matter.
bool accept_some(void*, const Ray& ray, const Hit& candidate) {
  return (candidate.prim_id + static_cast<std::uint32_t>(ray.time * 64.0f)) % 3 != 0;
}

bool same(const Hit& a, const Hit& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

TEST_P(BatchOnIsa, AnswersAsOneRayAtATime) {
  const HitFilter some{accept_some, nullptr};
  for (const Precision precision : {Precision::kWatertight, Precision::kFast}) {
    for (const float share : {1.0f, 0.5f}) {
      const auto structure = build(share, {.precision = precision});
      for (const HitFilter* filter : {static_cast<const HitFilter*>(nullptr), &some}) {
        for (const std::size_t count : {0u, 1u, 2u, 7u, 8u, 9u, 16u, 17u, 500u}) {
          std::vector<Spaced> rays;
          for (const Ray& ray : unlike_rays(count, static_cast<std::uint32_t>(count)))
            rays.push_back({ray, {1, 2, 3}});
          const std::vector<Spaced> before = rays;
          Found closest{rays.data(), std::vector<int>(count), std::vector<Hit>(count)};
          Found any = closest;
          RayBatch batch{rays.data(), sizeof(Spaced), count, Found::closest_hit, &closest, filter};
          structure->intersect_on(GetParam(), batch);
          batch.report = Found::any_hit;
          batch.user = &any;
          structure->occluded_on(GetParam(), batch);
          ASSERT_EQ(count == 0 ? 0 : std::memcmp(rays.data(), before.data(), count * sizeof(Spaced)), 0);
          int hits = 0;
          for (std::size_t i = 0; i < count; ++i) {
            SCOPED_TRACE(testing::Message() << count << " rays, ray " << i);
            Hit expected;
            const bool hit = structure->intersect_on(GetParam(), rays[i].ray, expected, filter);
            ASSERT_EQ(closest.times[i], hit ? 1 : 0);
            ASSERT_EQ(any.times[i], structure->occluded_on(GetParam(), rays[i].ray, filter) ? 1 : 0);
            if (hit) {
              ASSERT_TRUE(same(closest.hits[i], expected));
            }
            hits += hit;
          }
          if (count == 500) {
            EXPECT_GT(hits, 50);
          }
        }
      }
    }
  }
}

/// Returns how many rays hit.
int expect_same_side_by_side(const Structure& structure, const std::vector<Ray>& rays) {
  std::vector<Hit> hits(rays.size());
  const auto occluded = std::make_unique<bool[]>(rays.size());
  std::fill_n(occluded.get(), rays.size(), true);  // of the last call, say
  structure.intersect(rays, hits);
  structure.occluded(rays, std::span(occluded.get(), rays.size()));
  int found = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Hit expected;
    const bool hit = structure.intersect(rays[i], expected);
    EXPECT_EQ(hits[i].geom_id != kInvalidId, hit) << i;
    EXPECT_EQ(occluded[i], hit) << i;
    if (hit) {
      EXPECT_TRUE(same(hits[i], expected)) << i;
    }
    found += hit;
  }
  return found;
}

/// Large enough for rays in flight, unless they come from one point.
TEST(Batch, OfALargeStructure) {
  TestMesh mesh = test::soup(12000, 5, 23);
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  ASSERT_GT(structure->statistics().structure_bytes, 3u << 20);
  std::vector<Ray> rays = unlike_rays(400, 8);
  EXPECT_GT(expect_same_side_by_side(*structure, rays), 20);
  for (Ray& ray : rays) ray.origin = rays[0].origin;
  EXPECT_GT(expect_same_side_by_side(*structure, rays), 20);
}

TEST(Batch, OfASmallStructure) {
  TestMesh mesh = test::soup(200, 5, 21);
  const MeshView view = mesh.view();
  EXPECT_GT(expect_same_side_by_side(*Structure::build({&view, 1}), unlike_rays(300, 5)), 20);
}

TEST(Batch, OfAnEmptyStructureHitsNothing) {
  const auto structure = Structure::build({});
  const std::vector<Ray> rays = unlike_rays(20, 6);
  std::vector<Hit> hits(rays.size());
  structure->intersect(rays, hits);
  for (const Hit& hit : hits) EXPECT_EQ(hit.geom_id, kInvalidId);
}

/// Nobody need listen: filters collect what they see.
TEST(Batch, WithoutAReport) {
  TestMesh mesh = test::soup(200, 5, 22);
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  const std::vector<Ray> rays = unlike_rays(50, 7);
  int seen = 0;
  const HitFilter count{[](void* user, const Ray&, const Hit&) {
                          ++*static_cast<int*>(user);
                          return true;
                        },
                        &seen};
  structure->intersect({rays.data(), sizeof(Ray), rays.size(), nullptr, nullptr, &count});
  EXPECT_GT(seen, 5);
}

}  // namespace
}  // namespace stbvh
