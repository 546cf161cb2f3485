/// Structures of the gallery that bound in other directions than the axes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/oracle/judge.h"
#include "harness/rays/ray_generator.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/right_answers.h"
#include "tests/harness/test_scenes.h"
#include "tests/harness/trace_all.h"

namespace stbvh::harness {
namespace {

Vec3 random_direction(Pcg32& random) {
  const double z = random.uniform(-1, 1);
  const double angle = random.uniform(0, 2 * kPi);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// A flat grid of `cells` squared cells in a plane across `normal`, at each step by `motion` to and fro, so
/// that ours leaves out no step.
Mesh sheet(const Vec3& centre, const Vec3& normal, int cells, std::size_t steps, const Vec3& motion) {
  Mesh mesh;
  const Vec3 u = normalize(cross(normal, std::fabs(normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 v = cross(normal, u);
  const int side = cells + 1;
  for (std::size_t step = 0; step < steps; ++step) {
    VertexBuffer& buffer = mesh.steps.emplace_back(static_cast<std::size_t>(side * side));
    const Vec3 moved = step % 2 == 0 ? Vec3{0, 0, 0} : motion;
    for (int i = 0; i < side * side; ++i) {
      const double a = 4.0 * (i % side) / cells - 2;
      const double b = 4.0 * (i / side) / cells - 2;
      buffer[static_cast<std::size_t>(i)] = to_float(centre + u * a + v * b + moved);
    }
  }
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const auto at = [&](int dx, int dy) { return static_cast<std::uint32_t>((y + dy) * side + x + dx); };
      for (const std::uint32_t corner : {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)})
        mesh.indices.push_back(corner);
    }
  }
  return mesh;
}

/// Flat sheets in many directions, still and moving, some in themselves: their bounds are thin.
Scene sheets(const Vec3& centre) {
  Scene scene;
  scene.name = "sheets";
  Pcg32 random(3);
  for (std::size_t i = 0; i < 12; ++i) {
    const Vec3 normal = random_direction(random);
    const Vec3 place = centre + random_direction(random) * 4;
    const std::size_t steps = 1 + i % 4;
    scene.meshes.push_back(sheet(place, normal, 6, steps, random_direction(random) * 2));
  }
  scene.meshes.push_back(sheet(centre, {0, 0, 1}, 6, 2, {0, 0, 3}));
  scene.meshes.push_back(sheet(centre, normalize({1, 1, 1}), 6, 2, {-1, -1, -1}));
  return scene;
}

/// Towards random vertices at random times, from as far as `distance`; every other one in the plane of their
/// triangle, or nearly so.
std::vector<Ray> rays_at_vertices(const Scene& scene, double distance, std::size_t count) {
  Pcg32 random(9);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const auto pick = [&](std::size_t size) {
      return std::min(size - 1, static_cast<std::size_t>(random.uniform(0, static_cast<double>(size))));
    };
    const Mesh& mesh = scene.meshes[pick(scene.meshes.size())];
    const double time = random.uniform(0, 1);
    const double u = time * static_cast<double>(mesh.segment_count());
    const auto step = std::min(static_cast<std::size_t>(u), mesh.steps.size() - 1);
    const auto next = std::min(step + 1, mesh.steps.size() - 1);
    const auto place = [&](std::uint32_t vertex) {
      const Vec3 a = to_double(mesh.steps[step][vertex]);
      return a + (to_double(mesh.steps[next][vertex]) - a) * (u - static_cast<double>(step));
    };
    const std::size_t triangle = 3 * pick(mesh.triangle_count());
    const Vec3 target = place(mesh.indices[triangle]);
    Vec3 direction = random_direction(random);
    if (rays.size() % 2 == 1) {
      const double share = random.uniform(-1, 1);
      direction = normalize((place(mesh.indices[triangle + 1]) - target) * share +
                            (place(mesh.indices[triangle + 2]) - target) + direction * 1e-7);
    }
    Ray ray{};
    ray.origin = to_float(target - direction * distance);
    ray.direction = to_float(target - to_double(ray.origin));
    ray.time = static_cast<float>(time);
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = 0xFFFFFFFFu;
    rays.push_back(ray);
  }
  return rays;
}

class GallerySlabs : public ::testing::TestWithParam<std::string_view> {
 protected:
  static std::unique_ptr<StructureUnderTest> built(const Scene& scene, unsigned threads = 2) {
    return build_structure(GetParam(), scene, threads);
  }

  static void expect_right_answers(const Scene& scene) {
    harness::expect_right_answers(*built(scene), scene, 5000, 500);
  }

  /// The triangle test is ours: where no box hides what it accepts, the answers have the same bits.
  static void expect_our_answers(const Scene& scene, const std::vector<Ray>& rays, std::size_t least_hits) {
    const auto structure = built(scene);
    const auto ours = build_structure("stbvh-direct", scene, 2);
    std::size_t hits = 0;
    std::size_t differing = 0;
    for (const Ray& ray : rays) {
      Hit a, b;
      const bool is_hit = structure->intersect_one(ray, a);
      const bool is_ours = ours->intersect_one(ray, b);
      hits += is_ours;
      differing += is_hit != is_ours || (is_hit && a.t != b.t) || structure->occluded_one(ray) != is_ours;
    }
    EXPECT_GE(hits, least_hits);
    EXPECT_EQ(differing, 0u);
  }
};

TEST_P(GallerySlabs, AgreesWithTheOracle) {
  expect_right_answers(mixed_step_scene());
}

TEST_P(GallerySlabs, AgreesWithTheOracleOverUnevenSteps) {
  expect_right_answers(uneven_step_scene());
}

TEST_P(GallerySlabs, BoundsHideNothingThatTheTriangleTestAccepts) {
  for (const double away : {0.0, 1e3, 1e6}) {
    const Scene scene = sheets({away, -away, away});
    for (const double distance : {0.01, 10.0, 1e4, 1e7})
      expect_our_answers(scene, rays_at_vertices(scene, distance, 4000), 1000);
  }
}

TEST_P(GallerySlabs, TinyAndHugeScenesToo) {
  for (const double size : {1e-15, 1e15}) {
    Scene scene = sheets({0, 0, 0});
    for (Mesh& mesh : scene.meshes) {
      for (VertexBuffer& buffer : mesh.steps) {
        for (std::size_t i = 0; i < buffer.size(); ++i) buffer[i] = to_float(to_double(buffer[i]) * size);
      }
    }
    expect_our_answers(scene, rays_at_vertices(scene, 10 * size, 4000), 1000);
  }
}

TEST_P(GallerySlabs, OneTriangleOrNone) {
  const Ray through = ray_along_z(0.2f, 0.2f, 0.5f);
  Scene scene;
  Hit hit;
  EXPECT_FALSE(built(scene)->intersect_one(through, hit));
  scene.meshes.push_back(
      one_triangle({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {{{0, 0, 2}, {1, 0, 2}, {0, 1, 2}}}}));
  const auto one = built(scene);
  ASSERT_TRUE(one->intersect_one(through, hit));
  EXPECT_EQ(hit.t, 2.0f);  // from -1 to the middle of its way
  scene.meshes[0].indices = {0, 1, 7};
  EXPECT_FALSE(built(scene)->intersect_one(through, hit));
}

TEST_P(GallerySlabs, EmptySlotsAreMetByNoRay) {
  Scene scene;  // two leaves, thus six empty slots
  for (const float x : {-3.0f, 3.0f})
    scene.meshes.push_back(one_triangle({{{{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}}}}));
  const auto structure = built(scene);
  Pcg32 random(4);
  for (int i = 0; i < 2000; ++i) {
    Ray ray = ray_along_z(0, 0);
    const double far = i % 2 == 0 ? 10 : 0x1p125;
    ray.origin = to_float(random_direction(random) * far);
    ray.direction = to_float(random_direction(random));
    if (i % 3 == 0) ray.direction = {i % 4 < 2 ? 0.0f : -0.0f, i % 8 < 4 ? 1.0f : -1.0f, -0.0f};
    ray.tfar = std::numeric_limits<float>::infinity();
    TraversalCounters counters{};
    Hit hit;
    structure->intersect_one_counted(ray, hit, counters);
    EXPECT_EQ(counters.nodes, 1u);  // the link of an empty slot would lead back to it
  }
}

TEST_P(GallerySlabs, BuildsTheSameTwice) {
  const Scene scene = mixed_step_scene();
  const auto one = built(scene, 1);
  const auto two = built(scene, 2);
  EXPECT_EQ(one->build_record().structure_bytes, two->build_record().structure_bytes);
  TraversalCounters counters[2]{};
  for (const Ray& ray : rays_at_vertices(scene, 5, 2000)) {
    Hit hit;
    one->intersect_one_counted(ray, hit, counters[0]);
    two->intersect_one_counted(ray, hit, counters[1]);
  }
  EXPECT_GT(counters[0].nodes, 2000u);
  EXPECT_EQ(counters[0].nodes, counters[1].nodes);
  EXPECT_EQ(counters[0].leaves, counters[1].leaves);
}

Box3f box_of(const Outline& corners) {
  Box3f box = Box3f::empty();
  for (const Vec3f& corner : corners) extend(box, corner);
  return box;
}

TEST_P(GallerySlabs, OutlinesAreAroundWhatIsThere) {
  Scene scene;
  Pcg32 random(2);
  scene.meshes.push_back(wandering_triangles(400, 4, random));
  const auto structure = built(scene);
  for (const std::size_t step : {0u, 1u, 3u}) {
    for (const std::size_t level : {1u, 2u, 50u}) {
      const auto outlines = structure->outlines_at(static_cast<float>(step) / 3, level);
      ASSERT_GE(outlines.size(), level < 50 ? 1u : 50u);
      std::vector<Box3f> boxes;
      for (const Outline& outline : outlines) {
        ASSERT_GE(outline.size(), 4u);
        boxes.push_back(box_of(outline));
      }
      for (const Vec3f& p : scene.meshes[0].steps[step].span()) {
        const auto holds = [&](const Box3f& box) {
          constexpr float kRounding = 1e-4f;
          return p.x >= box.lower.x - kRounding && p.x <= box.upper.x + kRounding &&
                 p.y >= box.lower.y - kRounding && p.y <= box.upper.y + kRounding &&
                 p.z >= box.lower.z - kRounding && p.z <= box.upper.z + kRounding;
        };
        EXPECT_TRUE(std::ranges::any_of(boxes, holds)) << step << ' ' << level;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Gallery, GallerySlabs, ::testing::Values("obb-linear", "slabs-12"),
                         [](const auto& p) {
                           std::string name(p.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

/// Leaves that a thousand rays meet which hit sheets or pass by them.
std::size_t leaves_met(std::string_view name, const Scene& scene) {
  const auto structure = build_structure(name, scene, 2);
  TraversalCounters counters{};
  for (Ray ray : rays_at_vertices(scene, 10, 1000)) {
    ray.origin.x += 0.3f;
    Hit hit;
    structure->intersect_one_counted(ray, hit, counters);
  }
  return counters.leaves;
}

TEST(ObbLinear, FramesFollowWhatIsFlat) {
  Scene scene;
  scene.meshes.push_back(sheet({0, 0, 0}, normalize({1, 2, 3}), 30, 2, {1, 1, 0}));
  EXPECT_LT(leaves_met("obb-linear", scene), leaves_met("linear", scene) / 2);
}

TEST(Slabs12, DiagonalsFollowWhatMoves) {
  Scene scene;  // along a diagonal, within a segment, and as fast everywhere
  const double way = 8;
  scene.meshes.push_back(sheet({0, 0, 0}, normalize({1, 1, 1}), 30, 2, normalize({1, 1, 1}) * way));
  EXPECT_LT(leaves_met("slabs-12", scene), leaves_met("union", scene) / 2);
}

}  // namespace
}  // namespace stbvh::harness
