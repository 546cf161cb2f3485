/// Structures hold the steps that their meshes need: held against the motion as it was given.
#include "builder/step_reduction.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

#include "stbvh/structure.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

using test::TestMesh;

Vec3f at(const MeshView& mesh, const std::vector<std::size_t>& steps, std::size_t vertex, double time) {
  std::size_t k = 0;
  while (k + 2 < steps.size() && step_time(mesh, steps[k + 1]) <= time) ++k;
  if (steps.size() == 1) return mesh.steps[steps[0]].position(vertex);
  const double begin = step_time(mesh, steps[k]), end = step_time(mesh, steps[k + 1]);
  const double f = (time - begin) / (end - begin);
  const Vec3f p = mesh.steps[steps[k]].position(vertex), q = mesh.steps[steps[k + 1]].position(vertex);
  const auto mix = [f](float a, float b) { return static_cast<float>((1 - f) * a + f * b); };
  return {mix(p.x, q.x), mix(p.y, q.y), mix(p.z, q.z)};
}

/// The largest distance between the given motion and the reduced one, at many times.
double measured_deviation(const MeshView& mesh, const std::vector<std::size_t>& kept) {
  std::vector<std::size_t> all(mesh.steps.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const double begin = step_time(mesh, 0), end = step_time(mesh, all.back());
  double largest = 0;
  for (std::size_t i = 0; i <= 7 * all.back(); ++i) {
    const double time = begin + (end - begin) * static_cast<double>(i) / static_cast<double>(7 * all.back());
    for (std::size_t v = 0; v < mesh.steps[0].count; ++v) {
      const Vec3f a = at(mesh, all, v, time), b = at(mesh, kept, v, time);
      largest = std::max(largest, std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z));
    }
  }
  return largest;
}

StepReduction reduce(const MeshView& mesh, float tolerance) {
  std::vector<std::size_t> all(mesh.steps.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const VertexChoice vertices{mesh.steps[0].count,
                              [](std::size_t v) { return static_cast<std::uint32_t>(v); }};
  return reduce_steps(mesh, vertices, all, tolerance);
}

TestMesh sphere(std::size_t steps, const test::Motion& motion) {
  return test::sphere(8, steps, motion);
}

BuildStatistics statistics_of(TestMesh mesh, float tolerance = 0.0f) {
  const MeshView view = mesh.view();
  BuildSettings settings;
  settings.tolerance = tolerance;
  return Structure::build({&view, 1}, settings)->statistics();
}

TEST(StepReduction, WhatStandsStillIsStatic) {
  const TestMesh still = sphere(17, [](Vec3f p, float) { return p; });
  const BuildStatistics s = statistics_of(still);
  EXPECT_EQ(s.steps_given, 17u);
  EXPECT_EQ(s.steps_kept, 1u);
  EXPECT_EQ(s.max_deviation, 0.0);
  const BuildStatistics at_rest = statistics_of(sphere(1, [](Vec3f p, float) { return p; }));
  EXPECT_EQ(s.structure_bytes, at_rest.structure_bytes);
  EXPECT_EQ(s.nodes, at_rest.nodes);
}

/// Static meshes are hit at all times.
TEST(StepReduction, ButNotWhereItIsAliveInAPartOfTheShutter) {
  TestMesh still = sphere(17, [](Vec3f p, float) { return p; });
  still.time_range = {0.0f, 0.5f};
  EXPECT_EQ(statistics_of(still).steps_kept, 2u);
  const MeshView view = still.view();
  const auto structure = Structure::build({&view, 1});
  Hit hit;
  Ray ray{{0, 0, -5}, 0, {0.01f, 0.02f, 1}, 0.25f, 100};
  EXPECT_TRUE(structure->intersect(ray, hit));
  ray.time = 0.75f;
  EXPECT_FALSE(structure->intersect(ray, hit));
}

TEST(StepReduction, StraightMotionHasTwoSteps) {
  for (const Vec3f way : {Vec3f{1, 0, 0}, Vec3f{0.3f, -7, 2.1f}, Vec3f{1e-3f, 1e3f, 0.1f}}) {
    for (const std::size_t steps : {3u, 9u, 65u, 129u}) {
      // From below zero to above it: there coordinates have more digits than those of the ends.
      const TestMesh mesh = sphere(steps, [way](Vec3f p, float t) {
        const auto moved = [t](float x, float w) { return static_cast<float>(x + (t - 0.3) * w); };
        return Vec3f{moved(p.x, way.x), moved(p.y, way.y), moved(p.z, way.z)};
      });
      const BuildStatistics s = statistics_of(mesh);
      EXPECT_EQ(s.steps_kept, 2u) << way.x << ", " << steps;
      EXPECT_LE(s.max_deviation, 0x1p-23 * 1e3);
    }
  }
}

TEST(StepReduction, CurvedMotionKeepsAllStepsBitForBit) {
  TestMesh mesh = sphere(9, test::tumble);
  EXPECT_EQ(statistics_of(mesh).steps_kept, 9u);
  const MeshView view = mesh.view();
  BuildSettings keep;
  keep.tolerance = kKeepAllSteps;
  EXPECT_EQ(Structure::build({&view, 1})->tree_hash(), Structure::build({&view, 1}, keep)->tree_hash());
}

/// Of many vertices a sample guesses which steps are needed; what it does not see counts all the same.
TEST(StepReduction, OneVertexOfManyHasItsSay) {
  TestMesh mesh = test::soup(1000, 33, 7);
  const std::vector<Vec3f> still = mesh.positions[0];
  ASSERT_GT(still.size(), 1000u);
  mesh.positions.assign(33, still);
  for (const std::size_t vertex : {std::size_t{0}, std::size_t{3}, still.size() / 2 + 5, still.size() - 1}) {
    TestMesh one = mesh;
    one.positions[17][vertex].x += 1.0f;
    EXPECT_EQ(reduce(one.view(), 0.0f).kept, (std::vector<std::size_t>{0, 16, 17, 18, 32})) << vertex;
    EXPECT_EQ(measured_deviation(one.view(), reduce(one.view(), 0.0f).kept), 0.0) << vertex;
  }
}

/// As where only the eyelids of a figure move: what a guess has missed once it knows from then on.
TEST(StepReduction, FewVerticesThatMoveAreFoundOnce) {
  constexpr std::size_t kSteps = 129;
  TestMesh mesh = test::soup(4000, kSteps, 7);
  const std::vector<Vec3f> still = mesh.positions[0];
  mesh.positions.assign(kSteps, still);
  for (std::size_t step = 0; step < kSteps; ++step) {
    for (const std::size_t vertex : {still.size() / 3 + 1, still.size() / 2 + 1, still.size() - 3})
      mesh.positions[step][vertex].y += std::sin(0.1f * static_cast<float>(step * vertex % 1000));
  }
  std::vector<std::size_t> all(kSteps);
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::atomic<std::size_t> asked = 0;
  const VertexChoice vertices{still.size(), [&asked](std::size_t v) {
                                ++asked;
                                return static_cast<std::uint32_t>(v);
                              }};
  EXPECT_EQ(reduce_steps(mesh.view(), vertices, all, 0.0f).kept, all);
  EXPECT_LT(asked, 10 * still.size());
}

TEST(StepReduction, StaysWithinTheTolerance) {
  TestMesh meshes[] = {sphere(129, test::tumble),
                       test::at_times(sphere(129, test::tumble), test::uneven_times(129, 3)),
                       test::soup(20, 65, 5)};
  for (TestMesh& mesh : meshes) {
    const MeshView view = mesh.view();
    std::size_t previous = view.steps.size();
    for (const float tolerance : {1e-5f, 1e-4f, 1e-3f, 1e-2f, 1e-1f, 1e1f}) {
      const StepReduction r = reduce(view, tolerance);
      EXPECT_LE(r.deviation, tolerance);
      const double measured = measured_deviation(view, r.kept);
      EXPECT_LE(measured, r.deviation * (1 + 1e-6) + 1e-6);
      EXPECT_GE(measured, 0.9 * r.deviation - 1e-6) << "the deviation is that of the steps left out";
      EXPECT_EQ(r.kept.front(), 0u);
      if (r.kept.size() > 1) {
        EXPECT_EQ(r.kept.back(), view.steps.size() - 1);
      }
      EXPECT_LE(r.kept.size(), previous);
      previous = r.kept.size();
    }
    EXPECT_LE(previous, 2u);
  }
}

/// A time range that begins at a denormal time begins at 0, also where steps in between are left out.
TEST(StepReduction, DenormalTimesCountAsZero) {
  for (const float begin : {1e-40f, -1e-40f}) {
    TestMesh mesh = sphere(9, [](Vec3f p, float t) {
      return Vec3f{p.x, p.y, p.z + (t < 0.3f ? 0.0f : t - 0.25f)};
    });
    mesh.time_range = {begin, 1.0f};
    const MeshView view = mesh.view();
    const auto structure = Structure::build({&view, 1});
    ASSERT_EQ(structure->statistics().steps_kept, 3u);
    Hit hit;
    EXPECT_TRUE(structure->intersect({{0.01f, 0.02f, -5}, 0, {0, 0, 1}, 0.0f, 100}, hit)) << begin;
  }
}

/// As fine as it must be where something happens, and not elsewhere.
TEST(StepReduction, KeepsStepsWhereTheMotionIsCurved) {
  TestMesh mesh = sphere(129, [](Vec3f p, float t) {
    const float jump = t < 0.5f ? 0.0f : t > 0.6f ? 1.0f : 0.5f - 0.5f * std::cos(31.4159f * (t - 0.5f));
    return Vec3f{p.x + jump, p.y, p.z};
  });
  const StepReduction r = reduce(mesh.view(), 1e-3f);
  EXPECT_LT(r.kept.size(), 20u);
  for (const std::size_t step : r.kept) {
    const double t = static_cast<double>(step) / 128;
    EXPECT_TRUE(step == 0 || step == 128 || (t > 0.49 && t < 0.61)) << step;
  }
}

/// The last step is at the end of the time range, however its time would round.
TEST(StepReduction, WhatIsKeptLivesAsLongAsItWasGiven) {
  TestMesh mesh = sphere(17, [](Vec3f p, float t) { return Vec3f{p.x + std::min(t, 0.0625f), p.y, p.z}; });
  for (const TimeRange range : {TimeRange{-0x1p60f, 1.0f}, TimeRange{-1e9f, 0.1f}, TimeRange{-3.0f, 0.7f}}) {
    mesh.time_range = range;
    const MeshView view = mesh.view();
    const auto structure = Structure::build({&view, 1});
    EXPECT_EQ(structure->statistics().steps_kept, 3u);
    for (const float time : {0.0f, 0.5f * range.end, range.end}) {
      const Ray ray{{0.05f, 0.02f, 5}, 0, {0, 0, -1}, time, 100};
      EXPECT_TRUE(structure->occluded(ray)) << range.begin << ", " << time;
    }
    const Ray later{{0.05f, 0.02f, 5}, 0, {0, 0, -1}, std::nextafter(range.end, 2.0f), 100};
    EXPECT_FALSE(structure->occluded(later)) << range.begin;
  }
}

TEST(StepReduction, InvalidVerticesInStepsThatAreLeftOutStillCount) {
  TestMesh still = test::soup(10, 1, 4);
  still.positions.resize(5, still.positions[0]);
  still.positions[2][3 * 4].x = std::numeric_limits<float>::infinity();
  const BuildStatistics s = statistics_of(still);
  EXPECT_EQ(s.steps_kept, 1u);
  EXPECT_EQ(s.invalid_triangles, 1u);
  EXPECT_EQ(s.triangles, 9u);
}

/// The same rays hit the same triangles, as far off as the tolerance allows.
TEST(StepReduction, RaysMeetWhatIsKept) {
  TestMesh mesh = sphere(257, test::tumble);
  const MeshView view = mesh.view();
  BuildSettings keep, coarse;
  keep.tolerance = kKeepAllSteps;
  coarse.tolerance = 1e-3f;
  const auto given = Structure::build({&view, 1}, keep), reduced = Structure::build({&view, 1}, coarse);
  EXPECT_EQ(given->statistics().steps_kept, 257u);
  EXPECT_LT(reduced->statistics().steps_kept, 64u);
  EXPECT_LT(reduced->statistics().structure_bytes, given->statistics().structure_bytes / 2);
  test::Random random(8);
  int both = 0, one = 0;
  for (int i = 0; i < test::count(20000); ++i) {
    const Ray ray = test::random_ray(random);
    Hit a, b;
    const bool met_given = given->intersect(ray, a), met_reduced = reduced->intersect(ray, b);
    one += met_given != met_reduced;
    if (!met_given || !met_reduced || a.prim_id != b.prim_id) continue;
    ++both;
    const double length = std::hypot(ray.direction.x, ray.direction.y, ray.direction.z);
    const double normal = std::hypot(a.normal.x, a.normal.y, a.normal.z);
    const double facing =
        std::fabs(double{a.normal.x} * ray.direction.x + double{a.normal.y} * ray.direction.y +
                  double{a.normal.z} * ray.direction.z) /
        (normal * length);
    if (facing > 0.2) {
      EXPECT_NEAR(a.t * length, b.t * length, 2e-3 / facing);
    }
  }
  EXPECT_GT(both, test::count(3000));
  EXPECT_LT(one, both / 50);
}

/// Memory grows as the steps kept, whatever the number of those given.
TEST(StepReduction, AnyNumberOfStepsCostsWhatTheMotionNeeds) {
  const auto turn = [](Vec3f p, float t) {
    return Vec3f{p.x * std::cos(t) - p.y * std::sin(t), p.x * std::sin(t) + p.y * std::cos(t), p.z};
  };
  const BuildStatistics few = statistics_of(sphere(65, turn), 1e-3f);
  const BuildStatistics many = statistics_of(test::at_times(sphere(kMaxSteps, turn),
                                                            [] {
                                                              std::vector<float> times(kMaxSteps);
                                                              for (std::size_t i = 0; i < kMaxSteps; ++i)
                                                                times[i] =
                                                                    static_cast<float>(i) / (kMaxSteps - 1);
                                                              return times;
                                                            }()),
                                             1e-3f);
  EXPECT_EQ(many.steps_given, kMaxSteps);
  EXPECT_LE(many.steps_kept, few.steps_kept + 4);
  EXPECT_LE(many.structure_bytes, few.structure_bytes * 5 / 4);
  EXPECT_LE(many.max_deviation, 1e-3);
}

}  // namespace
}  // namespace stbvh
