/// The methods of the gallery that cut time otherwise than the STBVH: kd4, time-boxes, separate-N.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "harness/oracle/judge.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/frozen_scene.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/right_answers.h"
#include "tests/harness/test_scenes.h"
#include "tests/harness/trace_all.h"

namespace stbvh::harness {
namespace {

/// Hit or missed at the same t, to the bit: which of several triangles at one t is not asked.
void expect_answers_of_ours(const StructureUnderTest& structure, const Scene& scene,
                            std::span<const Ray> rays) {
  const auto ours = build_structure("stbvh-direct", scene, 2);
  std::size_t hits = 0;
  for (const Ray& ray : rays) {
    Hit expected{}, found{};
    const bool is_hit = ours->intersect_one(ray, expected);
    hits += is_hit;
    ASSERT_EQ(structure.intersect_one(ray, found), is_hit) << "at " << ray.time;
    ASSERT_EQ(found.t, expected.t) << "at " << ray.time;
    ASSERT_EQ(structure.occluded_one(ray), is_hit) << "at " << ray.time;
  }
  EXPECT_GT(hits, rays.size() / 20);
}

/// Times at which a step of a mesh begins, or at which time is halved, and their neighbours.
std::vector<float> times_at_borders(const Scene& scene) {
  std::vector<float> times{0.0f, 1.0f};
  const auto add = [&](double time) {
    const auto t = static_cast<float>(time);
    for (const float s : {std::nextafter(t, -1.0f), t, std::nextafter(t, 2.0f)}) {
      if (s >= 0.0f && s <= 1.0f) times.push_back(s);
    }
  };
  for (int i = 0; i <= 64; ++i) add(i / 64.0);
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.is_static()) continue;
    for (std::size_t step = 0; step < mesh.steps.size(); ++step) add(mesh.step_time(step));
  }
  return times;
}

/// From all around to points within [0, 10]^3.
std::vector<Ray> rays_at(const std::vector<float>& times, std::size_t count, double distance = 20) {
  Pcg32 random(3);
  std::vector<Ray> rays;
  const auto point = [&](double low, double high) {
    const double x = random.uniform(low, high), y = random.uniform(low, high);
    return Vec3{x, y, random.uniform(low, high)};
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 target = point(0, 10), origin = point(-distance, distance);
    const Vec3f from = to_float(origin);
    rays.push_back({from, 0.0f, to_float(target - to_double(from)), times[i % times.size()], 4.0f});
  }
  return rays;
}

/// A sheet of n x n squares in the plane z = 0, that shifts along x; its corners stand at multiples of 0.1.
Scene sheet(std::size_t n, std::size_t steps) {
  Scene scene;
  Mesh& mesh = scene.meshes.emplace_back();
  for (std::size_t step = 0; step < steps; ++step) {
    VertexBuffer& buffer = mesh.steps.emplace_back((n + 1) * (n + 1));
    for (std::size_t i = 0; i < buffer.size(); ++i) {
      const auto x = static_cast<float>(i % (n + 1)), y = static_cast<float>(i / (n + 1));
      buffer[i] = {x * 0.1f + static_cast<float>(step) * 0.7f, y * 0.1f, 0.0f};
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const auto row = static_cast<std::uint32_t>(n + 1), a = y * row + x;
      for (const std::uint32_t v : {a, a + 1, a + row, a + 1, a + row + 1, a + row})
        mesh.indices.push_back(v);
    }
  }
  return scene;
}

class EachExactMethod : public ::testing::TestWithParam<std::string_view> {};

TEST_P(EachExactMethod, AgreesWithTheOracle) {
  for (const Scene& scene : {mixed_step_scene(), uneven_step_scene()}) {
    SCOPED_TRACE(scene.name);
    expect_right_answers(*build_structure(GetParam(), scene, 2), scene, 2000, 200);
  }
}

TEST_P(EachExactMethod, FindsEverySegmentAtItsBorders) {
  for (const Scene& scene : {mixed_step_scene(), uneven_step_scene()}) {
    const auto structure = build_structure(GetParam(), scene, 2);
    expect_answers_of_ours(*structure, scene, rays_at(times_at_borders(scene), 20000));
  }
}

TEST_P(EachExactMethod, FindsWhatMovesOverTheWholeScene) {
  Scene scene = mixed_step_scene(200);
  for (Mesh& mesh : scene.meshes) {
    for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
      for (std::size_t i = 0; i < mesh.steps[step].size(); ++i)
        mesh.steps[step][i].x += static_cast<float>(step % 2) * 8.0f;
    }
  }
  const auto structure = build_structure(GetParam(), scene, 2);
  expect_answers_of_ours(*structure, scene, rays_at(times_at_borders(scene), 10000));
}

TEST_P(EachExactMethod, FindsWhatRaysFromFarAwayMeet) {
  const Scene scene = mixed_step_scene(30);  // from there the padding is as large as it
  const auto structure = build_structure(GetParam(), scene, 2);
  for (const double distance : {1e3, 1e5, 1e7})
    expect_answers_of_ours(*structure, scene, rays_at(times_at_borders(scene), 2000, distance));
}

TEST_P(EachExactMethod, TakesBigAndSmallCoordinates) {
  for (const float scale : {1e15f, 1e-15f}) {
    Scene scene = mixed_step_scene();
    for (Mesh& mesh : scene.meshes) {
      for (VertexBuffer& step : mesh.steps) {
        for (std::size_t i = 0; i < step.size(); ++i)
          step[i] = {step[i].x * scale, step[i].y * scale, step[i].z * scale};
      }
    }
    std::vector<Ray> rays = rays_at(times_at_borders(scene), 5000);
    for (Ray& ray : rays) {
      for (Vec3f* v : {&ray.origin, &ray.direction}) *v = {v->x * scale, v->y * scale, v->z * scale};
    }
    expect_answers_of_ours(*build_structure(GetParam(), scene, 2), scene, rays);
  }
}

/// Through the corners of the squares, at which boxes end and cells are cut: the triangle test lets none
/// through.
TEST_P(EachExactMethod, LeavesNoGapBetweenCells) {
  for (const std::size_t steps : {1u, 4u}) {
    const Scene scene = sheet(40, steps);
    const auto structure = build_structure(GetParam(), scene, 2);
    Pcg32 random(9);
    std::vector<Ray> rays;
    for (int i = 0; i < 40000; ++i) {
      const auto x = static_cast<float>(1 + random.next() % 39),
                 y = static_cast<float>(1 + random.next() % 39);
      const auto time = static_cast<float>(random.next() % 4) / 3.0f;
      const float shift = steps == 1 ? 0.0f : 2.1f * time;
      const Vec3f origin{static_cast<float>(random.uniform(-300, 300)),
                         static_cast<float>(random.uniform(-300, 300)), -50.0f};
      rays.push_back({origin, 0.0f, {x * 0.1f + shift - origin.x, y * 0.1f - origin.y, 50.0f}, time, 2.0f});
    }
    for (const Ray& ray : rays) {
      Hit hit;
      ASSERT_TRUE(structure->intersect_one(ray, hit));
      ASSERT_TRUE(structure->occluded_one(ray));
    }
  }
}

TEST_P(EachExactMethod, TakesNothingAndOneTriangle) {
  const std::array<Vec3f, 3> corners{Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0}};
  Scene scene;
  const Ray ray = ray_along_z(0.25f, 0.25f, 0.5f);
  EXPECT_FALSE(build_structure(GetParam(), scene, 1)->occluded_one(ray));
  scene.meshes.emplace_back().steps.emplace_back(0);  // empty
  EXPECT_FALSE(build_structure(GetParam(), scene, 1)->occluded_one(ray));
  scene.meshes.push_back(one_triangle({corners, corners}));
  scene.meshes.back().time_range = {1.5f, 2.0f};  // not there while the shutter is open
  EXPECT_FALSE(build_structure(GetParam(), scene, 1)->occluded_one(ray));
  EXPECT_TRUE(build_structure(GetParam(), scene, 1)->outlines_at(0.5f, 1).empty());
  scene.meshes.push_back(one_triangle({corners, corners, corners}));
  scene.meshes.back().time_range = {0.25f, 0.75f};
  const auto moving = build_structure(GetParam(), scene, 1);
  Hit hit{};
  ASSERT_TRUE(moving->intersect_one(ray, hit));
  EXPECT_EQ(hit.mesh, 2u);
  EXPECT_EQ(hit.t, 1.0f);
  EXPECT_FALSE(moving->occluded_one(ray_along_z(0.25f, 0.25f, 0.8f)));
  EXPECT_FALSE(moving->occluded_one(ray_along_z(2.0f, 0.25f, 0.5f)));
  scene.meshes = {one_triangle({corners})};
  EXPECT_TRUE(build_structure(GetParam(), scene, 1)->occluded_one(ray));
}

TEST_P(EachExactMethod, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = mixed_step_scene(1000);
  const auto one = build_structure(GetParam(), scene, 1);
  const auto two = build_structure(GetParam(), scene, 2);
  EXPECT_EQ(one->build_record().structure_bytes, two->build_record().structure_bytes);
  TraversalCounters counts[2];
  for (const Ray& ray : rays_at({0.1f, 0.3f, 0.9f}, 3000)) {
    Hit hit;
    one->intersect_one_counted(ray, hit, counts[0]);
    two->intersect_one_counted(ray, hit, counts[1]);
  }
  EXPECT_GT(counts[0].nodes, 3000u);
  EXPECT_GT(counts[0].leaves, 1000u);
  EXPECT_EQ(counts[0].nodes, counts[1].nodes);
  EXPECT_EQ(counts[0].leaves, counts[1].leaves);
}

TEST_P(EachExactMethod, WeighsItselfAndCanBeCancelled) {
  const Scene scene = mixed_step_scene(2000);
  const BuildRecord record = build_structure(GetParam(), scene, 2)->build_record();
  EXPECT_GT(record.build_s, 0);
  EXPECT_GT(record.structure_bytes, scene.triangle_count() * 10);
  EXPECT_GE(record.peak_bytes, record.structure_bytes);
  EXPECT_EQ(record.steps_kept, scene.step_count());
  EXPECT_THROW(build_structure(GetParam(), scene, 2, [](double) { return false; }), BuildCancelled);
}

INSTANTIATE_TEST_SUITE_P(Gallery, EachExactMethod, ::testing::Values("kd4", "time-boxes"),
                         [](const auto& p) { return p.param == "kd4" ? "kd4" : "time_boxes"; });

double volume(const Outline& outline) {
  Box3f box = Box3f::empty();
  for (const Vec3f& corner : outline) box.extend(corner);
  const Vec3 size = to_double(box.upper) - to_double(box.lower);
  return size.x * size.y * size.z;
}

TEST(Kd4, ItsCellsFillTheSpaceAtAnyTime) {
  const auto tree = build_structure("kd4", mixed_step_scene(), 2);
  for (const float time : {0.0f, 0.3f, 1.0f}) {
    const std::vector<Outline> root = tree->outlines_at(time, 0);
    ASSERT_EQ(root.size(), 1u);
    for (const std::size_t level : {3u, 8u, 100u}) {
      const std::vector<Outline> cells = tree->outlines_at(time, level);
      EXPECT_GT(cells.size(), std::min<std::size_t>(level, 30));
      double all = 0;
      for (const Outline& cell : cells) all += volume(cell);
      EXPECT_NEAR(all, volume(root[0]), 1e-5 * all);
    }
  }
  EXPECT_TRUE(is_scalar("kd4"));
}

/// One mesh ends and one begins at the time at which the shutter is halved.
TEST(Kd4, ATimeBelongsToOneSide) {
  Scene scene;
  Pcg32 random(4);
  for (const TimeRange range : {TimeRange{0.0f, 0.5f}, TimeRange{0.5f, 1.0f}}) {
    scene.meshes.push_back(wandering_triangles(1000, 3, random));
    scene.meshes.back().time_range = range;
  }
  const float before = std::nextafter(0.5f, 0.0f), after = std::nextafter(0.5f, 1.0f);
  const auto tree = build_structure("kd4", scene, 2);
  expect_answers_of_ours(*tree, scene, rays_at({before, 0.5f, after}, 5000));
}

/// The mesh moves by its size: its boxes at one time are a small part of those of all times.
TEST(Kd4, TimeIsSplitWhereThatSeparates) {
  Scene scene;
  Pcg32 random(2);
  Mesh& mesh = scene.meshes.emplace_back(wandering_triangles(2000, 9, random));
  for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
    for (std::size_t i = 0; i < mesh.steps[step].size(); ++i)
      mesh.steps[step][i].x += static_cast<float>(step);
  }
  const auto tree = build_structure("kd4", scene, 2);
  const auto union_tree = build_structure("union", scene, 2);
  TraversalCounters ours, others;
  for (const Ray& ray : rays_at({0.0f, 0.1f}, 2000)) {
    Hit hit;
    tree->intersect_one_counted(ray, hit, ours);
    union_tree->intersect_one_counted(ray, hit, others);
  }
  EXPECT_LT(ours.leaves * 3, others.leaves);
}

TEST(TimeBoxes, TooManyReferencesAreRefused) {
  Scene scene;
  Mesh& mesh = scene.meshes.emplace_back();
  mesh.indices.resize(3 * 5 * 10'000'000);
  mesh.steps.resize(4);
  EXPECT_NE(obstacle("time-boxes", scene).find("30 million references"), std::string::npos);
  mesh.steps.resize(3);
  EXPECT_EQ(obstacle("time-boxes", scene), "");
}

TEST(Separate, AnswersWithTheSceneAtTheCentreOfTheWindow) {
  const Scene scene = mixed_step_scene();  // of which two meshes are not there in the first of eight windows
  const auto trees = build_structure("separate-8", scene, 2);
  EXPECT_FALSE(is_exact("separate-8"));
  const std::vector<Ray> rays = rays_at({0.0f, 1.0f}, 2000);
  for (std::size_t window = 0; window < 8; ++window) {
    const float centre = (static_cast<float>(window) + 0.5f) / 8.0f;
    const Scene still = frozen(scene, centre);
    std::vector<std::uint32_t> numbers;  // of the meshes that are there
    for (std::uint32_t i = 0; i < scene.meshes.size(); ++i) {
      const TimeRange range = scene.meshes[i].motion_range();
      if (scene.meshes[i].is_static() || (centre >= range.begin && centre <= range.end)) numbers.push_back(i);
    }
    ASSERT_EQ(numbers.size(), still.meshes.size());
    const auto tree = build_structure("stbvh-direct", still, 2);
    const float begin = static_cast<float>(window) / 8.0f;
    const float last = window == 7 ? 1.0f : std::nextafter(begin + 0.125f, 0.0f);
    for (Ray ray : rays) {
      ray.time = ray.time == 0.0f ? begin : last;
      Hit expected{}, found{};
      const bool is_hit = tree->intersect_one(ray, expected);
      ASSERT_EQ(trees->intersect_one(ray, found), is_hit);
      ASSERT_EQ(trees->occluded_one(ray), is_hit);
      if (!is_hit) continue;
      ASSERT_EQ(found.t, expected.t);
      ASSERT_EQ(found.prim_id, expected.prim_id);
      ASSERT_EQ(found.geom_id, numbers[expected.geom_id]);
      ASSERT_EQ(found.mesh, numbers[expected.mesh]);
    }
  }
}

TEST(Separate, HitsNothingOutsideOfTheShutter) {
  const auto trees = build_structure("separate-2", sheet(2, 1), 1);
  Ray ray = ray_along_z(0.15f, 0.12f, 1.0f);
  EXPECT_TRUE(trees->occluded_one(ray));
  for (const float time : {-0.1f, 1.1f, std::nanf("")}) {
    ray.time = time;
    EXPECT_FALSE(trees->occluded_one(ray));
  }
}

TEST(Separate, TheErrorFallsWithTheNumberOfTrees) {
  const Scene scene = find_procedural_scene("wheels")->make(0.005, 1);
  const auto exact = build_structure("stbvh-direct", scene, 2);
  const RaySet rays = make_rays(RayKind::kUniform, scene, *exact, 4000, 3);
  const std::vector<HitRecord> truth = trace_all(*exact, rays);
  std::size_t before = rays.rays.size();
  std::size_t bytes_before = 0;
  for (const std::string name : {"separate-2", "separate-8", "separate-32"}) {
    const auto trees = build_structure(name, scene, 2);
    const std::vector<HitRecord> hits = trace_all(*trees, rays);
    std::size_t differing = 0;
    for (std::size_t i = 0; i < hits.size(); ++i)
      differing += hits[i].geom_id != truth[i].geom_id || hits[i].prim_id != truth[i].prim_id;
    EXPECT_GT(differing, 0u) << name;
    EXPECT_LT(differing * 5, before * 4) << name;
    before = differing;
    EXPECT_GT(trees->build_record().structure_bytes, 3 * bytes_before) << name;
    bytes_before = trees->build_record().structure_bytes;
  }
}

}  // namespace
}  // namespace stbvh::harness
