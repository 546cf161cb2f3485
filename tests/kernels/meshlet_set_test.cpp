#include "builder/meshlet_set.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>

#include "builder/build_context.h"
#include "hard_meshes.h"

namespace stbvh {
namespace {

using test::TestMesh;

/// The meshlets of one mesh, and all that has to live with them.
class Meshlets {
 public:
  explicit Meshlets(TestMesh source, BuildCallbacks callbacks = {})
      : source_(std::move(source)),
        callbacks_(std::move(callbacks)),
        context_({}, callbacks_),
        mesh_(source_.view(), 0, kKeepAllSteps),
        set_(make_meshlets(context_, mesh_)) {}
  Meshlets(const Meshlets&) = delete;
  Meshlets& operator=(const Meshlets&) = delete;

  const BuildMesh& mesh() const { return mesh_; }
  const MeshletSet& set() const { return set_; }
  std::span<const Meshlet> all() const { return set_.meshlets(); }
  std::size_t vertices() const {
    return std::accumulate(all().begin(), all().end(), std::size_t{0},
                           [](std::size_t sum, const Meshlet& m) { return sum + m.vertex_count; });
  }
  double mean_triangles() const {
    return static_cast<double>(set_.triangles) / static_cast<double>(all().size());
  }
  const BuildMemory& memory() const { return context_.memory; }
  void clear() { set_ = {}; }

 private:
  TestMesh source_;
  BuildCallbacks callbacks_;
  BuildContext context_;
  BuildMesh mesh_;
  MeshletSet set_;
};

/// Whether two vertices are at the same place at every step.
bool coincide(const BuildMesh& mesh, std::uint32_t a, std::uint32_t b) {
  for (std::size_t step = 0; step <= mesh.segments(); ++step) {
    const Vec3f p = mesh.position(step, a), q = mesh.position(step, b);
    if (std::memcmp(&p, &q, sizeof p) != 0) return false;
  }
  return true;
}

/// That the corners of triangle `i` are where the mesh has them; marks the slots they use.
void expect_corners(const BuildMesh& mesh, const Meshlet& m, std::size_t i, std::array<bool, kWidth>& used) {
  const TriangleIndices triangle = mesh.triangle(m.prims[i]);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint8_t slot = m.corners[corner][i];
    ASSERT_LT(slot, m.vertex_count);
    used[slot] = true;
    ASSERT_TRUE(coincide(mesh, m.vertices[slot], triangle[corner])) << "triangle " << m.prims[i];
  }
}

/// Whatever the mesh: its valid triangles, each once, with their corners, in meshlets of at most eight.
void expect_sound(const Meshlets& meshlets) {
  const BuildMesh& mesh = meshlets.mesh();
  std::vector<int> seen(mesh.view().triangle_count);
  for (const Meshlet& m : meshlets.all()) {
    ASSERT_GE(m.triangle_count, 1);
    ASSERT_LE(m.triangle_count, kWidth);
    ASSERT_GE(m.vertex_count, 1);
    ASSERT_LE(m.vertex_count, kWidth);
    std::array<bool, kWidth> used{};
    for (std::size_t i = 0; i < m.triangle_count; ++i) {
      ASSERT_LT(m.prims[i], seen.size());
      ++seen[m.prims[i]];
      ASSERT_NO_FATAL_FAILURE(expect_corners(mesh, m, i, used));
    }
    for (std::size_t a = 0; a < m.vertex_count; ++a) {
      EXPECT_TRUE(used[a]) << "a slot without a corner";
      for (std::size_t b = 0; b < a; ++b) {
        EXPECT_FALSE(coincide(mesh, m.vertices[a], m.vertices[b])) << "a vertex with two slots";
      }
    }
  }
  std::size_t valid = 0;
  for (std::size_t prim = 0; prim < seen.size(); ++prim) {
    const bool is_valid = mesh.is_valid(mesh.triangle(prim));
    EXPECT_EQ(seen[prim], is_valid ? 1 : 0) << "triangle " << prim;
    valid += is_valid;
  }
  EXPECT_EQ(meshlets.set().triangles, valid);
  EXPECT_EQ(meshlets.set().invalid_triangles, seen.size() - valid);
}

/// Bytes that equal meshlets share, whatever stands in unused slots.
bool same(const Meshlet& a, const Meshlet& b) {
  if (a.triangle_count != b.triangle_count || a.vertex_count != b.vertex_count) return false;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    if (!std::equal(a.corners[corner], a.corners[corner] + a.triangle_count, b.corners[corner])) return false;
  }
  return std::equal(a.prims, a.prims + a.triangle_count, b.prims);
}

/// `n` x `n` squares of two triangles each, waving; vertices shared.
TestMesh grid(std::uint32_t n, std::size_t steps) {
  std::vector<Vec3f> rest;
  TestMesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      rest.push_back(
          {static_cast<float>(x) / static_cast<float>(n), static_cast<float>(y) / static_cast<float>(n), 0});
      if (x == n || y == n) continue;
      const std::uint32_t a = y * (n + 1) + x, b = a + n + 1;
      mesh.indices.insert(mesh.indices.end(), {a, a + 1, b, a + 1, b + 1, b});
    }
  }
  test::animate(mesh, rest, steps, [](Vec3f p, float t) {
    return Vec3f{p.x + 0.2f * t, p.y, 0.1f * std::sin(7 * p.x + 5 * t)};
  });
  return mesh;
}

/// The same triangles, each with three vertices of its own.
TestMesh without_sharing(const TestMesh& mesh) {
  TestMesh apart;
  apart.positions.resize(mesh.positions.size());
  for (const std::uint32_t vertex : mesh.indices) {
    apart.indices.push_back(static_cast<std::uint32_t>(apart.indices.size()));
    for (std::size_t k = 0; k < mesh.positions.size(); ++k) {
      apart.positions[k].push_back(mesh.positions[k][vertex]);
    }
  }
  return apart;
}

/// Two triangles with six vertices; those of the edge they meet at coincide in the steps where `meets`.
TestMesh two_triangles(const std::vector<bool>& meets) {
  TestMesh mesh;
  mesh.indices = {0, 1, 2, 3, 4, 5};
  for (std::size_t k = 0; k < meets.size(); ++k) {
    const float z = 0.01f * static_cast<float>(k);
    const float gap = meets[k] ? 0.0f : 1e-3f;
    mesh.positions.push_back(
        {{0, 0, z}, {1, 0, z}, {0, 1, z}, {1 + gap, 0, z}, {gap, 1, z}, {1 + gap, 1 + gap, z}});
  }
  return mesh;
}

TEST(Meshlets, HoldEachValidTriangleOnce) {
  expect_sound(Meshlets(grid(20, 1)));
  expect_sound(Meshlets(grid(20, 2)));
  expect_sound(Meshlets(test::sphere(20, 9)));
  expect_sound(Meshlets(without_sharing(test::sphere(20, 3))));
  expect_sound(Meshlets(test::soup(3000, 4, 1)));
  expect_sound(Meshlets(test::soup(1, 3, 1)));
  expect_sound(Meshlets(test::needles(2000, 5, 2)));
  expect_sound(Meshlets(test::flat(2000, 3, 3, true)));
  expect_sound(Meshlets(test::flat(2000, 3, 4, false)));
}

TEST(Meshlets, HoldEachTriangleOnceInMoreThanOneRun) {
  for (const std::size_t triangles : {8192u, 8193u, 20000u}) {
    expect_sound(Meshlets(test::soup(triangles, 2, 5)));
  }
  expect_sound(Meshlets(grid(120, 3)));
}

TEST(Meshlets, LeaveOutAndCountInvalidTriangles) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  TestMesh mesh = test::soup(20000, 3, 6);
  std::size_t invalid = 0;
  for (std::size_t prim = 0; prim < 20000; prim += 1 + prim % 7) {
    const std::size_t vertex = 3 * prim + prim % 3;
    float& coordinate = mesh.positions[prim % 3][vertex].y;
    if (prim % 4 == 0) coordinate = kNan;
    if (prim % 4 == 1) coordinate = -std::numeric_limits<float>::infinity();
    if (prim % 4 == 2) coordinate = kMaxCoordinate;
    if (prim % 4 == 3) mesh.indices[vertex] = prim % 8 == 3 ? 60000 : 0xFFFFFFFFu;
    ++invalid;
  }
  const Meshlets meshlets(mesh);
  EXPECT_EQ(meshlets.set().invalid_triangles, invalid);
  EXPECT_EQ(meshlets.set().triangles, 20000 - invalid);
  expect_sound(meshlets);
}

TEST(Meshlets, OfNothingAreNone) {
  TestMesh empty = test::soup(10, 3, 7);
  empty.indices.clear();
  EXPECT_TRUE(Meshlets(empty).all().empty());
  EXPECT_EQ(Meshlets(empty).set().invalid_triangles, 0u);

  for (const std::size_t triangles : {10u, 10000u}) {
    TestMesh invalid = test::soup(triangles, 3, 7);
    for (Vec3f& p : invalid.positions[1]) p.x = std::numeric_limits<float>::quiet_NaN();
    const Meshlets meshlets(invalid);
    EXPECT_TRUE(meshlets.all().empty());
    EXPECT_EQ(meshlets.set().triangles, 0u);
    EXPECT_EQ(meshlets.set().invalid_triangles, triangles);
  }
}

TEST(Meshlets, AreTheSameForAnyNumberOfThreads) {
  const TestMesh meshes[] = {grid(130, 2), test::soup(30000, 3, 8), without_sharing(test::sphere(70, 2))};
  for (const TestMesh& mesh : meshes) {
    const Meshlets expected(mesh);
    for (int run = 0; run < test::count(5); ++run) {
      for (const std::size_t threads : {1u, 2u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const Meshlets meshlets(mesh);
        ASSERT_TRUE(std::equal(expected.all().begin(), expected.all().end(), meshlets.all().begin(),
                               meshlets.all().end(), same))
            << threads << " threads";
      }
    }
  }
}

/// Measured: 5.7 to 6.0 triangles in a meshlet of these.
TEST(Meshlets, OfConnectedMeshesAreWellFilled) {
  constexpr double kWellFilled = 5.5;
  EXPECT_GE(Meshlets(grid(30, 1)).mean_triangles(), kWellFilled);
  EXPECT_GE(Meshlets(grid(100, 1)).mean_triangles(), kWellFilled);
  EXPECT_GE(Meshlets(grid(100, 5)).mean_triangles(), kWellFilled);
  EXPECT_GE(Meshlets(test::sphere(50, 9)).mean_triangles(), kWellFilled);
}

TEST(Meshlets, WeldVerticesThatDifferInIndexOnly) {
  for (const TestMesh& mesh : {grid(100, 3), test::sphere(30, 1), test::sphere(30, 5)}) {
    const Meshlets shared(mesh), apart(without_sharing(mesh));
    expect_sound(apart);
    EXPECT_TRUE(
        std::equal(shared.all().begin(), shared.all().end(), apart.all().begin(), apart.all().end(), same));
  }
}

TEST(Meshlets, DoNotWeldVerticesThatEverDiffer) {
  for (const std::size_t steps : {1u, 2u, 5u, 9u}) {
    const Meshlets welded(two_triangles(std::vector<bool>(steps, true)));
    EXPECT_EQ(welded.vertices(), 4u);
    EXPECT_EQ(welded.all().size(), 1u);
    expect_sound(welded);
    for (std::size_t k = 0; steps > 1 && k < steps; ++k) {
      std::vector<bool> once(steps, false), all_but_once(steps, true);
      once[k] = true;
      all_but_once[k] = false;
      for (const std::vector<bool>& meets : {once, all_but_once}) {
        const Meshlets apart(two_triangles(meets));
        EXPECT_EQ(apart.vertices(), 6u) << "step " << k << " of " << steps;
        EXPECT_EQ(apart.all().size(), 1u) << "so near that they share a leaf all the same";
        expect_sound(apart);
      }
    }
  }
}

TEST(Meshlets, TakeRepeatedVerticesAndPoints) {
  TestMesh mesh = grid(20, 3);
  for (std::size_t prim = 0; prim < mesh.indices.size() / 3; prim += 3) {
    std::uint32_t* const corners = &mesh.indices[3 * prim];
    corners[1 + prim % 2] = corners[0];
    if (prim % 4 == 0) corners[1] = corners[2] = corners[0];
  }
  expect_sound(Meshlets(mesh));
  expect_sound(Meshlets(without_sharing(mesh)));

  TestMesh points = test::soup(1000, 2, 9, 0.0f);  // each triangle starts as a point
  points.positions[1] = points.positions[0];
  expect_sound(Meshlets(points));

  TestMesh one_triangle = test::soup(1, 2, 10);
  for (int i = 1; i < 1000; ++i) one_triangle.indices.insert(one_triangle.indices.end(), {0, 1, 2});
  const Meshlets copies(one_triangle);
  expect_sound(copies);
  EXPECT_EQ(copies.all().size(), 125u);
}

TEST(Meshlets, TakeCoordinatesOfAnySize) {
  const double filled = Meshlets(grid(50, 2)).mean_triangles();
  for (const float scale : {1e17f, 1.5e18f, 1e-17f}) {
    const Meshlets meshlets(test::placed(grid(50, 2), scale, 0));
    expect_sound(meshlets);
    EXPECT_NEAR(meshlets.mean_triangles(), filled, 0.1) << scale;  // the order of a curve may change
  }
  expect_sound(Meshlets(test::placed(grid(50, 2), 1e-30f, 0)));
  expect_sound(Meshlets(test::placed(grid(50, 2), 1e-42f, 0)));
  expect_sound(Meshlets(test::placed(grid(50, 2), 1, 1e17f)));  // far away, where most vertices coincide
  TestMesh corners = test::soup(3000, 3, 11);                   // the largest extents that are valid
  for (auto& step : corners.positions) {
    for (Vec3f& p : step) {
      const float most = std::nextafter(kMaxCoordinate, 0.0f);
      p = {std::copysign(most, p.x), std::copysign(most, p.y), std::copysign(most, p.z)};
    }
  }
  expect_sound(Meshlets(corners));
}

/// All start from one point, as what grows does.
TEST(Meshlets, TakeMeshesThatCoincideAtOneStep) {
  for (const std::size_t step : {0u, 1u, 3u, 4u}) {
    TestMesh mesh = grid(90, 5);
    std::fill(mesh.positions[step].begin(), mesh.positions[step].end(), Vec3f{1, 2, 3});
    const Meshlets meshlets(mesh);
    expect_sound(meshlets);
    EXPECT_GE(meshlets.mean_triangles(), 4.5) << step;
  }
}

TEST(Meshlets, TakeFansOfThousands) {
  TestMesh fan = grid(100, 2);
  for (std::size_t corner = 0; corner < fan.indices.size(); corner += 3) fan.indices[corner] = 0;
  expect_sound(Meshlets(fan));
}

TEST(Meshlets, TakeCoordinatesThatAreAllEqual) {
  for (const float x : {0.0f, 1.0f, -1e17f}) {
    TestMesh mesh = test::soup(3000, 2, 12);
    for (auto& step : mesh.positions) std::fill(step.begin(), step.end(), Vec3f{x, x, x});
    const Meshlets meshlets(mesh);
    expect_sound(meshlets);
    EXPECT_EQ(meshlets.all().size(), 375u) << "eight triangles over one vertex each";
  }
}

TEST(Meshlets, GiveTemporaryMemoryBack) {
  for (const TestMesh& mesh : {grid(20, 2), grid(120, 2)}) {  // one run, and four
    Meshlets meshlets(mesh);
    EXPECT_EQ(meshlets.memory().current(), meshlets.all().size() * sizeof(Meshlet));
    EXPECT_GT(meshlets.memory().peak(), meshlets.memory().current());
    meshlets.clear();
    EXPECT_EQ(meshlets.memory().current(), 0u);
  }
}

TEST(Meshlets, GiveTemporaryMemoryBackWhenItIsRefused) {
  const TestMesh mesh = grid(120, 2);
  int refused = 0;
  for (int allowed = 0;; ++allowed) {
    std::atomic<std::ptrdiff_t> bytes{0};
    std::atomic<int> left{allowed};
    BuildCallbacks callbacks;
    callbacks.temporary_memory = [&](std::ptrdiff_t more) {
      if (more > 0 && left.fetch_sub(1) <= 0) return false;
      bytes += more;
      return true;
    };
    bool cancelled = false;
    try {
      expect_sound(Meshlets(mesh, callbacks));
    } catch (const BuildCancelled&) {
      cancelled = true;
    }
    EXPECT_EQ(bytes.load(), 0) << allowed << " pieces allowed";
    if (!cancelled) break;
    ++refused;
  }
  EXPECT_EQ(refused, 10) << "the triangles, four runs and what they keep meanwhile, and all meshlets";
}

/// As when the build of another mesh has thrown: TBB skips the runs that are left, and throws nothing itself.
TEST(Meshlets, AreCancelledWithTheTaskTheyAreMadeIn) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  tbb::task_group_context task;
  int taken = 0;
  BuildCallbacks callbacks;
  callbacks.temporary_memory = [&](std::ptrdiff_t more) {
    if (more > 0 && ++taken == 2) task.cancel_group_execution();  // in the first run
    return true;
  };
  tbb::task_group(task).run_and_wait(
      [&] { EXPECT_THROW(Meshlets(grid(120, 2), callbacks), BuildCancelled); });
  EXPECT_EQ(taken, 3) << "the first run is finished";
}

}  // namespace
}  // namespace stbvh
