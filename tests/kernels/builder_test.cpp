#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <numbers>
#include <string>

#include "layout/layout.h"
#include "limited.h"
#include "stbvh/structure.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

using test::TestMesh;

std::vector<TestMesh> mixed_meshes() {
  std::vector<TestMesh> meshes;
  meshes.push_back(test::sphere(40, 9));
  meshes.push_back(test::soup(3000, 5, 3));
  meshes.push_back(test::sphere(20, 1, test::tumble, {2, 0, 0}));
  meshes.push_back(test::soup(500, 17, 4));
  meshes[3].time_range = {0.2f, 0.7f};
  return meshes;
}

std::vector<MeshView> views(std::vector<TestMesh>& meshes) {
  std::vector<MeshView> v;
  for (TestMesh& mesh : meshes) v.push_back(mesh.view());
  return v;
}

TEST(Builder, SameTreeForAnyNumberOfThreads) {
  std::vector<TestMesh> meshes = mixed_meshes();
  meshes.push_back(test::sphere(150, 4, test::tumble, {0, 1, 0}));  // large enough for parallel binning
  const std::vector<MeshView> v = views(meshes);
  const std::uint64_t expected = Structure::build(v)->tree_hash();
  for (int run = 0; run < test::count(10); ++run) {
    for (const int threads : {1, 2}) {
      tbb::task_arena arena(threads);
      arena.execute([&] { EXPECT_EQ(Structure::build(v)->tree_hash(), expected) << threads << " threads"; });
    }
  }
  meshes[0].positions[4][100].x += 1e-3f;
  EXPECT_NE(Structure::build(views(meshes))->tree_hash(), expected);
}

TEST(Builder, StatisticsAddUpToTheBytes) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const auto structure = Structure::build(views(meshes));
  const BuildStatistics& s = structure->statistics();
  const std::size_t triangles = meshes[0].indices.size() / 3 + 3000 + meshes[2].indices.size() / 3 + 500;
  EXPECT_EQ(s.triangles, triangles);
  EXPECT_EQ(s.primitive_segments,
            meshes[0].indices.size() / 3 * 8 + 3000 * 4 + meshes[2].indices.size() / 3 + 500 * 16);
  const std::size_t node_bytes = s.nodes[0] * sizeof(StaticNode) + s.nodes[1] * sizeof(LinearNode) +
                                 s.nodes[2] * sizeof(SpatialTemporalNode);
  EXPECT_GE(s.structure_bytes, node_bytes + s.leaf_bytes);
  EXPECT_LE(s.structure_bytes, node_bytes + s.leaf_bytes + 8192);
  EXPECT_GE(s.peak_bytes, s.structure_bytes);
  EXPECT_GT(s.nodes[0], 0u) << "the static mesh should have static nodes";
  EXPECT_GT(s.nodes[2], 0u);
  EXPECT_GE(s.leaf_triangles, s.triangles);
}

void expect_limits_of_bytes_kept(std::vector<TestMesh> meshes) {
  const BuildStatistics all = Structure::build(views(meshes))->statistics();
  EXPECT_EQ(all.indexed_leaves, 0u);
  EXPECT_EQ(all.wanted_bytes, all.structure_bytes);
  const std::size_t least = test::smallest_bytes(views(meshes));
  EXPECT_LT(least, all.structure_bytes * 3 / 4);
  std::size_t previous = 0;
  for (const double share : {0.0, 0.01, 0.1, 0.25, 0.5, 0.75, 0.99, 1.0}) {
    BuildSettings settings;
    settings.max_bytes =
        least + static_cast<std::size_t>(share * static_cast<double>(all.structure_bytes - least));
    const BuildStatistics s = Structure::build(views(meshes), settings)->statistics();
    EXPECT_LE(s.structure_bytes, settings.max_bytes);
    EXPECT_GE(s.structure_bytes, settings.max_bytes * 8 / 10) << "what may be spent is spent: " << share;
    EXPECT_GE(s.structure_bytes, previous);
    EXPECT_GE(s.wanted_bytes, s.structure_bytes);
    EXPECT_EQ(s.triangles, all.triangles);
    previous = s.structure_bytes;
  }
  BuildSettings generous;
  generous.max_bytes = 2 * all.structure_bytes;
  EXPECT_EQ(Structure::build(views(meshes), generous)->tree_hash(),
            Structure::build(views(meshes))->tree_hash())
      << "more than rays profit from is not spent";
}

TEST(Builder, KeepsToEveryLimitOfBytes) {
  expect_limits_of_bytes_kept(mixed_meshes());
  expect_limits_of_bytes_kept({test::sphere(40, 1), test::soup(2000, 1, 51)});
}

TEST(Builder, RefusesALimitBelowTheSmallestStructure) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const std::size_t least = test::smallest_bytes(views(meshes));
  BuildSettings settings;
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, least / 2, least - 1}) {
    settings.max_bytes = bytes;
    try {
      Structure::build(views(meshes), settings);
      ADD_FAILURE() << bytes << " of " << least;
    } catch (const MemoryLimit& limit) {
      EXPECT_EQ(limit.needed_bytes, least);
      EXPECT_NE(std::string(limit.what()).find(std::to_string(least)), std::string::npos);
    }
  }
  EXPECT_THROW(Structure::build({}, settings = {.max_bytes = 8}), MemoryLimit);
  settings.max_bytes = least;
  EXPECT_EQ(Structure::build(views(meshes), settings)->statistics().structure_bytes, least);
}

/// Also while it is built, with whatever is temporary.
TEST(Builder, KeepsToEveryLimitOfItsPeak) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const std::size_t all = Structure::build(views(meshes))->statistics().peak_bytes;
  std::size_t built = 0;
  for (std::size_t peak = all; peak > all / 20; peak -= all / 20) {
    BuildSettings settings;
    settings.max_peak_bytes = peak;
    std::ptrdiff_t taken = 0, most = 0;
    BuildCallbacks callbacks;
    std::mutex mutex;
    callbacks.temporary_memory = [&](std::ptrdiff_t bytes) {
      const std::lock_guard lock(mutex);
      taken += bytes;
      most = std::max(most, taken);
      return true;
    };
    try {
      const auto structure = Structure::build(views(meshes), settings, callbacks);
      EXPECT_LE(structure->statistics().peak_bytes, peak);
      EXPECT_EQ(structure->statistics().triangles, Structure::build(views(meshes))->statistics().triangles);
      ++built;
    } catch (const MemoryLimit& limit) {
      EXPECT_EQ(limit.needed_bytes, 0u);
    }
    EXPECT_LE(most, static_cast<std::ptrdiff_t>(peak));
    EXPECT_EQ(taken, 0);
  }
  EXPECT_GT(built, 3u);
}

TEST(Builder, InvalidPrimitivesAreLeftOutAndCounted) {
  TestMesh mesh = test::soup(100, 3, 5);
  mesh.indices[0] = 300;  // triangle 0: index out of range
  mesh.indices[3 * 7] = 0xFFFFFFFFu;
  mesh.positions[1][3 * 20].y = std::numeric_limits<float>::quiet_NaN();  // triangle 20, one step only
  mesh.positions[2][3 * 30].z = std::numeric_limits<float>::infinity();
  mesh.positions[0][3 * 40].x = 1e30f;
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  EXPECT_EQ(structure->statistics().invalid_triangles, 5u);
  EXPECT_EQ(structure->statistics().triangles, 95u);
  test::Random random(1);
  for (int i = 0; i < test::count(20000); ++i) {
    Hit hit;
    if (!structure->intersect(test::random_ray(random), hit)) continue;
    for (const std::uint32_t invalid : {0u, 7u, 20u, 30u, 40u}) EXPECT_NE(hit.prim_id, invalid);
  }
}

TEST(Builder, UnreadableMeshesAreRefused) {
  TestMesh mesh = test::soup(10, 3, 6);
  const auto expect_refused = [&](auto change) {
    MeshView view = mesh.view();
    change(view);
    EXPECT_NE(problem_of(view), nullptr);
    EXPECT_THROW(Structure::build({&view, 1}), InvalidMesh);
  };
  expect_refused([](MeshView& v) { v.steps = {}; });
  expect_refused([](MeshView& v) { v.indices = nullptr; });
  expect_refused([](MeshView& v) { v.index_stride = 4; });
  constexpr auto kBack = static_cast<std::size_t>(-12);
  expect_refused([](MeshView& v) { v.index_stride = kBack; });
  expect_refused([](MeshView& v) { v.index_stride = std::size_t{1} << 62; });
  expect_refused([](MeshView& v) { v.indices = reinterpret_cast<const void*>(~std::uintptr_t{15}); });
  expect_refused([](MeshView& v) { v.time_range = {0.5f, 0.5f}; });
  expect_refused([](MeshView& v) { v.time_range = {1.0f, 0.0f}; });
  expect_refused([](MeshView& v) { v.time_range = {std::numeric_limits<float>::quiet_NaN(), 1.0f}; });
  std::vector<VertexBufferView> steps(kMaxSteps + 1, mesh.steps[0]);
  expect_refused([&](MeshView& v) { v.steps = steps; });
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  const std::vector<std::vector<float>> bad_times{{0, 1},          {0, 0.5f, 0.75f, 1}, {0, 0.5f, 0.5f},
                                                  {0, 1, 0.5f},    {0, kNan, 1},        {-kInf, 0, 1},
                                                  {0, 0.5f, kInf}, {0, 1e-40f, 1},      {-3e38f, 0, 3e38f}};
  for (const std::vector<float>& times : bad_times)
    expect_refused([&](MeshView& v) { v.step_times = times; });
  steps.resize(2);
  steps[1].data = nullptr;
  expect_refused([&](MeshView& v) { v.steps = steps; });
  steps[1] = {mesh.steps[0].data, 3, 12};
  expect_refused([&](MeshView& v) { v.steps = steps; });
  for (const std::size_t stride : {std::size_t{8}, kBack, std::size_t{1} << 60}) {
    steps[1] = {mesh.steps[0].data, 30, stride};
    expect_refused([&](MeshView& v) { v.steps = steps; });
  }
}

TEST(Builder, EmptyInputsHitNothing) {
  test::Random random(2);
  Hit hit;
  EXPECT_FALSE(Structure::build({})->intersect(test::random_ray(random), hit));
  TestMesh mesh = test::soup(10, 3, 6);
  mesh.indices.clear();
  const MeshView none = mesh.view();
  EXPECT_FALSE(Structure::build({&none, 1})->occluded(test::random_ray(random)));
  TestMesh outside = test::soup(10, 3, 6);
  outside.time_range = {2.0f, 3.0f};
  const MeshView late = outside.view();
  EXPECT_FALSE(Structure::build({&late, 1})->occluded(test::random_ray(random)));
}

TEST(Builder, DuplicatesAndPointsEndInBoundedDepth) {
  TestMesh mesh;
  mesh.positions.assign(3, {});
  for (std::uint32_t i = 0; i < 5000; ++i) {
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      mesh.indices.push_back(3 * i + corner);
      const float x = static_cast<float>(corner % 2), y = static_cast<float>(corner / 2);
      for (auto& step : mesh.positions) step.push_back(i < 2500 ? Vec3f{x, y, 0} : Vec3f{0, 0, 0});
    }
  }
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  EXPECT_LE(structure->statistics().depth, 88u);
  EXPECT_EQ(structure->statistics().leaf_triangles, 5000u);
  Ray ray{{0.2f, 0.2f, -1}, 0, {0, 0, 1}, 0.5f, 10, 0xFFFFFFFFu};
  Hit hit;
  ASSERT_TRUE(structure->intersect(ray, hit));
  EXPECT_FLOAT_EQ(hit.t, 1.0f);
}

TEST(Builder, CancelLeavesNothingBehind) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const std::vector<MeshView> v = views(meshes);
  for (const double stop : {0.0, 0.3, 0.9, 1.0}) {
    std::atomic<std::ptrdiff_t> bytes{0}, blocks{0};
    BuildCallbacks callbacks;
    callbacks.temporary_memory = [&](std::ptrdiff_t b) { return bytes += b, true; };
    callbacks.allocate = [&](std::size_t b) { return ++blocks, std::aligned_alloc(64, (b + 63) / 64 * 64); };
    callbacks.release = [&](void* data, std::size_t) { --blocks, std::free(data); };
    callbacks.progress = [&](double fraction) { return fraction < stop; };
    EXPECT_THROW(Structure::build(v, {}, callbacks), BuildCancelled) << stop;
    EXPECT_EQ(bytes.load(), 0);
    EXPECT_EQ(blocks.load(), 0);
  }
}

TEST(Builder, RefusedMemoryCancels) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const std::vector<MeshView> v = views(meshes);
  std::atomic<std::ptrdiff_t> bytes{0};
  BuildCallbacks callbacks;
  callbacks.temporary_memory = [&](std::ptrdiff_t b) {
    if (b > 0 && bytes + b > 500000) return false;
    bytes += b;
    return true;
  };
  EXPECT_THROW(Structure::build(v, {}, callbacks), BuildCancelled);
  EXPECT_EQ(bytes.load(), 0);
}

TEST(Builder, ProgressRisesToOneAndMemoryIsGivenBack) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const std::vector<MeshView> v = views(meshes);
  std::vector<double> seen;
  std::atomic<std::ptrdiff_t> bytes{0}, blocks{0};
  BuildCallbacks callbacks;
  callbacks.progress = [&](double fraction) { return seen.push_back(fraction), true; };
  callbacks.temporary_memory = [&](std::ptrdiff_t b) { return bytes += b, true; };
  callbacks.allocate = [&](std::size_t b) { return ++blocks, std::aligned_alloc(64, (b + 63) / 64 * 64); };
  callbacks.release = [&](void* data, std::size_t) { --blocks, std::free(data); };
  auto structure = Structure::build(v, {}, callbacks);
  EXPECT_EQ(bytes.load(), 0);
  EXPECT_EQ(blocks.load(), 1);
  structure.reset();
  EXPECT_EQ(blocks.load(), 0);
  ASSERT_GE(seen.size(), 3u);  // at least: how often a build asks depends on how its threads run
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_EQ(seen.front(), 0.0);
  EXPECT_EQ(seen.back(), 1.0);
}

TEST(Builder, BoundsAtHoldEveryPosition) {
  std::vector<TestMesh> meshes = mixed_meshes();
  const auto structure = Structure::build(views(meshes));
  const TestMesh& mesh = meshes[0];
  for (int i = 0; i <= 64; ++i) {
    const float t = static_cast<float>(i) / 64.0f;
    const Box3f box = structure->bounds_at(t);
    const float u = t * 8.0f;
    const auto k = std::min<std::size_t>(static_cast<std::size_t>(u), 7);
    const float f = u - static_cast<float>(k);
    for (std::size_t vertex = 0; vertex < mesh.positions[0].size(); ++vertex) {
      const Vec3f& a = mesh.positions[k][vertex];
      const Vec3f& b = mesh.positions[k + 1][vertex];
      EXPECT_GE((1 - f) * a.x + f * b.x, box.lower.x);
      EXPECT_LE((1 - f) * a.y + f * b.y, box.upper.y);
      EXPECT_LE((1 - f) * a.z + f * b.z, box.upper.z);
    }
  }
}

/// Found by fuzz_build: (1 - t) * x + t * x is not always x.
TEST(Builder, BoundsAtHoldWhatStandsStill) {
  std::vector<TestMesh> meshes{test::sphere(12, 1)};
  const auto structure = Structure::build(views(meshes));
  for (int i = 0; i <= 1000; ++i) {
    const float t = static_cast<float>(i) / 1000.0f;
    const Box3f box = structure->bounds_at(t);
    for (const Vec3f& p : meshes[0].positions[0]) {
      ASSERT_TRUE(p.x >= box.lower.x && p.y >= box.lower.y && p.z >= box.lower.z) << t;
      ASSERT_TRUE(p.x <= box.upper.x && p.y <= box.upper.y && p.z <= box.upper.z) << t;
    }
  }
}

/// Half of the time of what turns round and round takes as much room as all of it: only parts of a turn take
/// less.
TEST(Builder, SplitsTurnsInTimeHoweverManyThereAre) {
  constexpr int kTurns = 12;
  const auto circling = [](Vec3f p, float t) {
    const float angle = 2 * std::numbers::pi_v<float> * kTurns * t;
    const float x = p.x + 5.0f;
    return Vec3f{x * std::cos(angle) - p.y * std::sin(angle), x * std::sin(angle) + p.y * std::cos(angle),
                 p.z};
  };
  test::TestMesh mesh = test::sphere(12, 16 * kTurns + 1, circling);
  const MeshView view = mesh.view();
  const auto structure = Structure::build({&view, 1});
  test::Random random(1);
  TraversalCounters counters;
  constexpr int kRays = 2000;
  for (int i = 0; i < kRays; ++i) {
    const Vec3f to{10 * random.unit() - 5, 10 * random.unit() - 5, 0};
    Hit hit;
    structure->intersect_counted({{to.x, to.y, 5}, 0, {0, 0, -1}, random.unit(), 100}, hit, counters);
  }
  // The sphere covers 4 % of these rays, and the ring that it sweeps half of them.
  EXPECT_LT(counters.leaves, kRays / 2);
  EXPECT_GT(structure->statistics().temporal_splits, 64u);
}

}  // namespace
}  // namespace stbvh
