/// Parts of a mesh that move otherwise than the rest: as if they were meshes of their own, and without gaps.
#include <gtest/gtest.h>

#include <limits>

#include "stbvh/structure.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

using test::TestMesh;

constexpr std::size_t kSteps = 17;

Vec3f still(Vec3f p, float) {
  return p;
}
Vec3f straight(Vec3f p, float t) {
  return {p.x, p.y + 0.3f * t, p.z};
}

/// Both in one mesh; of the same steps.
TestMesh joined(TestMesh a, const TestMesh& b) {
  const auto first = static_cast<std::uint32_t>(a.positions[0].size());
  for (const std::uint32_t index : b.indices) a.indices.push_back(first + index);
  for (std::size_t step = 0; step < a.positions.size(); ++step)
    a.positions[step].insert(a.positions[step].end(), b.positions[step].begin(), b.positions[step].end());
  return a;
}

std::unique_ptr<Structure> build(std::vector<TestMesh*> meshes, float tolerance = 0.0f,
                                 const BuildCallbacks& callbacks = {}) {
  std::vector<MeshView> views;
  for (TestMesh* mesh : meshes) views.push_back(mesh->view());
  BuildSettings settings;
  settings.tolerance = tolerance;
  return Structure::build(views, settings, callbacks);
}

std::size_t segments_of(TestMesh mesh, float tolerance = 0.0f) {
  return build({&mesh}, tolerance)->statistics().primitive_segments;
}

/// A grid over [-1, 1]^2 whose two halves share no vertices; the right one waves away from the border.
/// `apart_at`: the step at which the halves are apart.
TestMesh halved_grid(std::size_t apart_at = kSteps) {
  constexpr std::uint32_t kSide = 12;
  TestMesh grid;
  for (std::size_t step = 0; step < kSteps; ++step) {
    grid.positions.emplace_back();
    const float t = static_cast<float>(step) / (kSteps - 1);
    for (const float half : {-1.0f, 0.0f}) {
      for (std::uint32_t i = 0; i <= kSide; ++i) {
        for (std::uint32_t j = 0; j <= kSide; ++j) {
          const float x = half + static_cast<float>(i) / kSide, y = 2.0f * static_cast<float>(j) / kSide - 1;
          const float wave = half < 0 ? 0.0f : x * std::sin(7 * t + y);
          const float gap = half == 0 && step == apart_at ? 0.1f : 0.0f;
          grid.positions.back().push_back({x + gap, y, wave});
        }
      }
    }
  }
  for (std::uint32_t half = 0; half < 2; ++half) {
    for (std::uint32_t i = 0; i < kSide; ++i) {
      for (std::uint32_t j = 0; j < kSide; ++j) {
        const std::uint32_t a = (half * (kSide + 1) + i) * (kSide + 1) + j, b = a + kSide + 1;
        grid.indices.insert(grid.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
      }
    }
  }
  return grid;
}

TEST(MeshParts, AnswerAsMeshesOfTheirOwn) {
  TestMesh decoy = test::sphere(4, 1, still, {5, 0, 0});
  TestMesh a = test::sphere(8, kSteps, still), b = test::sphere(8, kSteps, test::tumble, {0.5f, 0, 0}),
           c = test::sphere(8, kSteps, straight, {-0.5f, 0, 0});
  TestMesh all = joined(joined(a, b), c);
  const std::size_t triangles = a.indices.size() / 3;
  a.geom_id = b.geom_id = c.geom_id = all.geom_id = 7;
  const auto parts = build({&decoy, &all}), meshes = build({&decoy, &a, &b, &c});
  const BuildStatistics &s = parts->statistics(), &expected = meshes->statistics();
  EXPECT_EQ(s.primitive_segments, expected.primitive_segments);
  EXPECT_EQ(s.triangles, expected.triangles);
  EXPECT_EQ(s.nodes, expected.nodes);
  EXPECT_EQ(s.steps_given, 1 + kSteps);
  EXPECT_EQ(s.steps_kept, 1 + kSteps) << "each step by any of the parts, once";
  test::Random random(3);
  int met = 0;
  for (int i = 0; i < test::count(20000); ++i) {
    const Ray ray = test::random_ray(random);
    Hit hit, other;
    ASSERT_EQ(parts->intersect(ray, hit), meshes->intersect(ray, other));
    ASSERT_EQ(parts->occluded(ray), meshes->occluded(ray));
    if (!meshes->intersect(ray, other)) continue;
    ++met;
    ASSERT_EQ(hit.t, other.t);
    ASSERT_EQ(hit.u, other.u);
    ASSERT_EQ(hit.v, other.v);
    ASSERT_EQ(hit.geom_id, other.geom_id);
    ASSERT_EQ(hit.mesh, other.mesh == 0 ? 0u : 1u);
    ASSERT_EQ(hit.prim_id, other.mesh == 0 ? other.prim_id : (other.mesh - 1) * triangles + other.prim_id);
  }
  EXPECT_GT(met, test::count(5000));
}

TEST(MeshParts, KeepStepsOfTheWhole) {
  const auto bent = [](Vec3f p, float t) { return Vec3f{p.x + std::fabs(t - 0.5f), p.y, p.z}; };
  const TestMesh a = test::sphere(8, kSteps, bent), b = test::sphere(8, kSteps, test::tumble, {3, 0, 0});
  const std::size_t triangles = a.indices.size() / 3;
  EXPECT_EQ(segments_of(joined(a, b)), triangles * (2 + kSteps - 1));
  const auto uneven = [](TestMesh mesh) {
    return test::at_times(std::move(mesh), test::uneven_times(kSteps, 4));
  };
  EXPECT_EQ(segments_of(uneven(joined(test::sphere(8, kSteps, still), b))), triangles * (1 + kSteps - 1));
}

TEST(MeshParts, AreWithinTheTolerance) {
  TestMesh all = joined(test::sphere(8, 65, test::tumble), test::sphere(8, 65, still, {2, 0, 0}));
  for (const float tolerance : {1e-3f, 1e-2f}) {
    const auto structure = build({&all}, tolerance);
    EXPECT_LE(structure->statistics().max_deviation, static_cast<double>(tolerance));
    EXPECT_GT(structure->statistics().max_deviation, 0.0);
    EXPECT_LT(structure->statistics().primitive_segments, all.indices.size() / 3 * 40);
  }
}

TEST(MeshParts, OfAMeshThatIsNotAliveAllTheTimeDoNotStandStillForEver) {
  TestMesh all = joined(test::sphere(8, kSteps, still), test::sphere(8, kSteps, test::tumble, {3, 0, 0}));
  all.time_range = {0.25f, 0.75f};
  const auto structure = build({&all});
  for (const float time : {0.0f, 0.2f, 0.3f, 0.7f, 0.8f, 1.0f}) {
    const Ray ray{{0, 0, 5}, 0, {0.01f, 0.02f, -1}, time, 100};
    EXPECT_EQ(structure->occluded(ray), time > 0.25f && time < 0.75f) << time;
  }
}

TEST(MeshParts, MeetWithoutGaps) {
  TestMesh grid = halved_grid();
  EXPECT_EQ(segments_of(grid), grid.indices.size() / 3 * (kSteps - 1)) << "the halves are connected";
  const auto structure = build({&grid});
  test::Random random(5);
  for (int i = 0; i < test::count(20000); ++i) {
    const float y = 1.9f * random.unit() - 0.95f;
    const Vec3f from{random.unit() - 0.5f, y + random.unit() - 0.5f, 3};
    const Ray ray{from, 0, {-from.x, y - from.y, -from.z}, random.unit(), 2};
    ASSERT_TRUE(structure->occluded(ray)) << i;
  }
  for (const std::size_t apart_at : {std::size_t{0}, std::size_t{8}, kSteps - 1}) {
    grid = halved_grid(apart_at);
    EXPECT_EQ(segments_of(grid), grid.indices.size() / 3 * (kSteps - 1)) << apart_at;
  }
}

TEST(MeshParts, SignsOfZerosDoNotPartThem) {
  TestMesh grid = halved_grid();
  for (std::vector<Vec3f>& step : grid.positions) {
    for (std::size_t v = 0; v < step.size() / 2; ++v) {
      if (step[v].x == 0.0f) step[v].x = -0.0f;
    }
  }
  EXPECT_EQ(segments_of(grid), grid.indices.size() / 3 * (kSteps - 1));
}

TEST(MeshParts, BadTrianglesDoNotConnectThem) {
  TestMesh all = joined(test::sphere(8, kSteps, still), test::sphere(8, kSteps, test::tumble, {3, 0, 0}));
  const std::size_t triangles = all.indices.size() / 6;
  all.indices.insert(all.indices.end(),
                     {0, static_cast<std::uint32_t>(all.positions[0].size()) - 1, 0xFFFFFFFFu});
  const auto structure = build({&all});
  EXPECT_EQ(structure->statistics().invalid_triangles, 1u);
  EXPECT_EQ(structure->statistics().primitive_segments, triangles * (1 + kSteps - 1));
}

TEST(MeshParts, TellTheirBounds) {
  TestMesh all = joined(test::sphere(8, kSteps, still), test::sphere(8, kSteps, test::tumble, {3, 0, 0}));
  BuildCallbacks callbacks;
  std::vector<std::size_t> steps;
  callbacks.step_bounds = [&](std::size_t mesh, const std::vector<Box3f>& boxes, std::span<const float>) {
    EXPECT_EQ(mesh, 0u);
    steps.push_back(boxes.size());
  };
  build({&all}, 0.0f, callbacks);
  std::ranges::sort(steps);
  EXPECT_EQ(steps, (std::vector<std::size_t>{1, kSteps}));
}

/// Looking for parts is not what a build fails of.
TEST(MeshParts, AreLeftOutWhereThereIsNoMemoryToFindThem) {
  TestMesh all = joined(test::sphere(8, kSteps, still), test::sphere(8, kSteps, test::tumble, {3, 0, 0}));
  for (auto& step : all.positions) step.resize(1'000'000);  // most of them not used
  const MeshView view = all.view();
  BuildSettings settings;
  settings.max_peak_bytes = 2'000'000;
  const auto structure = Structure::build({&view, 1}, settings);
  EXPECT_EQ(structure->statistics().primitive_segments, view.triangle_count * (kSteps - 1));
  EXPECT_LE(structure->statistics().peak_bytes, settings.max_peak_bytes);
}

/// Vertices of no triangle, and invalid ones, connect nothing.
TEST(MeshParts, AreNotConnectedByWhatIsNotBuilt) {
  TestMesh all = joined(test::sphere(8, kSteps, still), test::sphere(8, kSteps, test::tumble, {3, 0, 0}));
  const std::size_t triangles = all.indices.size() / 6;
  const auto vertices = static_cast<std::uint32_t>(all.positions[0].size());
  for (std::size_t step = 0; step < kSteps; ++step) {
    auto& positions = all.positions[step];
    positions.push_back(positions[vertices / 2 + 5 * (step % 2)]);  // beside either, and used by none
    positions.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  }
  all.indices.insert(all.indices.end(), {0, vertices - 1, vertices + 1});
  const auto structure = build({&all});
  EXPECT_EQ(structure->statistics().invalid_triangles, 1u);
  EXPECT_EQ(structure->statistics().primitive_segments, triangles * (1 + kSteps - 1));
}

/// Many components, each with a motion of its own: their number does not grow.
TEST(MeshParts, AreFew) {
  TestMesh all = test::sphere(8, 65, still);
  for (int i = 1; i < 60; ++i) {
    const auto kink = static_cast<float>(i) / 64;
    all = joined(std::move(all), test::sphere(8, 65,
                                              [kink](Vec3f p, float t) {
                                                return Vec3f{p.x + std::fabs(t - kink), p.y, p.z};
                                              },
                                              {static_cast<float>(3 * i), 0, 0}));
  }
  BuildCallbacks callbacks;
  int parts = 0;
  callbacks.step_bounds = [&](std::size_t, const std::vector<Box3f>&, std::span<const float>) { ++parts; };
  const auto structure = build({&all}, 0.0f, callbacks);
  EXPECT_GT(parts, 1);
  EXPECT_LE(parts, 16);
  const Ray ray{{3 * 7, 0, 5}, 0, {0.01f, 0.02f, -1}, 0.3f, 100};
  EXPECT_TRUE(structure->occluded(ray));
}

}  // namespace
}  // namespace stbvh
