/// refine() against what is known of Catmull-Clark surfaces without OpenSubdiv.
#include "harness/scenes/subdivision/subdivision.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "harness/scenes/subdivision/cage_topology.h"
#include "harness/scenes/subdivision/degenerate_parts.h"
#include "tests/harness/test_cages.h"

namespace stbvh::harness {
namespace {

using Boundary = SubdivisionCage::Boundary;

double volume(const Mesh& mesh, std::size_t step = 0) {
  double sum = 0;
  const VertexBuffer& p = mesh.steps[step];
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    const Vec3f a = p[mesh.indices[t]], b = p[mesh.indices[t + 1]], c = p[mesh.indices[t + 2]];
    sum += double{a.x} * (double{b.y} * c.z - double{b.z} * c.y) +
           double{a.y} * (double{b.z} * c.x - double{b.x} * c.z) +
           double{a.z} * (double{b.x} * c.y - double{b.y} * c.x);
  }
  return sum / 6;
}

/// Distance from `p` to the nearest vertex of the first step.
double distance_to_vertices(const Mesh& mesh, double x, double y, double z) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3f& q : mesh.steps[0].span())
    nearest = std::min(nearest, std::hypot(q.x - x, q.y - y, q.z - z));
  return nearest;
}

bool same_bits(const VertexBuffer& a, const VertexBuffer& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3f)) == 0;
}

std::string refusal(const SubdivisionCage& cage, const RefinementTarget& target = {}) {
  try {
    refine(cage, target);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

std::array<double, 4> cubic_basis(double f) {
  return {(1 - f) * (1 - f) * (1 - f) / 6, (3 * f * f * f - 6 * f * f + 4) / 6,
          (-3 * f * f * f + 3 * f * f + 3 * f + 1) / 6, f * f * f / 6};
}

/// Height of the uniform bicubic B-spline of the grid's vertices; x and y from 1 to count - 2.
double spline_height(std::size_t count, double x, double y) {
  const auto span = [&](double t) { return std::clamp(std::floor(t), 1.0, static_cast<double>(count - 3)); };
  const std::array<double, 4> bx = cubic_basis(x - span(x)), by = cubic_basis(y - span(y));
  double sum = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      sum += bx[i] * by[j] *
             height(static_cast<std::size_t>(span(x)) - 1 + i, static_cast<std::size_t>(span(y)) - 1 + j);
    }
  }
  return sum;
}

TEST(Subdivision, ARegularGridIsTheBicubicBSpline) {
  constexpr std::uint32_t kCount = 7;
  for (unsigned level = 0; level <= 4; ++level) {
    const Mesh mesh = refine(grid(kCount, Boundary::kNone), {level, {}});
    const std::size_t side = ((kCount - 3) << level) + 1;
    ASSERT_EQ(mesh.steps[0].size(), side * side);
    EXPECT_EQ(mesh.triangle_count(), 2 * (side - 1) * (side - 1));
    for (const Vec3f& p : mesh.steps[0].span()) {
      const double x = std::round(double{p.x} * 16) / 16, y = std::round(double{p.y} * 16) / 16;
      ASSERT_NEAR(p.x, x, 1e-5);
      ASSERT_NEAR(p.y, y, 1e-5);
      ASSERT_GE(std::min(x, y), 1);
      ASSERT_LE(std::max(x, y), kCount - 2);
      ASSERT_NEAR(p.z, spline_height(kCount, x, y), 1e-5) << x << " " << y;
    }
  }
}

TEST(Subdivision, TheCubesVerticesGoToTheirLimits) {
  // Limit of a vertex with n edges: (n^2 v + 4 edge neighbours + face neighbours) / (n (n + 5)).
  const double corner = (9 + 4 * 1 - 1) / 24.0;
  const Mesh least = refine(cube(), {0, {}});
  EXPECT_EQ(least.steps[0].size(), 8u);
  EXPECT_EQ(least.triangle_count(), 12u);
  const VertexBuffer cage = cube().steps[0];
  for (std::size_t v = 0; v < 8; ++v) {
    EXPECT_NEAR(least.steps[0][v].x, corner * cage[v].x, 1e-6);
    EXPECT_NEAR(least.steps[0][v].y, corner * cage[v].y, 1e-6);
    EXPECT_NEAR(least.steps[0][v].z, corner * cage[v].z, 1e-6);
  }
  // After one step by hand: face point 1, edge points 3/4, vertex points 5/9; then the mask of four edges.
  const double face = (16 + 4 * 4 * 0.75 + 4 * 5.0 / 9) / 36;
  for (unsigned level = 1; level <= 4; ++level) {
    const Mesh mesh = refine(cube(), {level, {}});
    EXPECT_EQ(mesh.triangle_count(), std::size_t{12} << (2 * level));
    EXPECT_LT(distance_to_vertices(mesh, corner, corner, corner), 1e-6);
    EXPECT_LT(distance_to_vertices(mesh, corner, -corner, -corner), 1e-6);
    EXPECT_LT(distance_to_vertices(mesh, 0, 0, face), 1e-6);
    EXPECT_LT(distance_to_vertices(mesh, 0, -face, 0), 1e-6);
  }
}

TEST(Subdivision, SharpEdgesStayStraight) {
  for (const float sharpness : {10.f, 100.f, std::numeric_limits<float>::infinity()}) {
    const Mesh mesh = refine(cube_with_creases(sharpness), {3, {}});
    std::size_t on_edges = 0;
    for (const Vec3f& p : mesh.steps[0].span()) {
      std::size_t ones = 0;
      for (const float x : {p.x, p.y, p.z}) {
        ones += std::abs(std::abs(x) - 1) < 1e-6 ? 1u : 0u;
        EXPECT_NEAR(x * 4, std::round(x * 4), 1e-5);  // and evenly cut
      }
      EXPECT_GE(ones, 1u);
      on_edges += ones >= 2 ? 1u : 0u;
    }
    EXPECT_EQ(on_edges, 12u * 7 + 8);
    EXPECT_NEAR(volume(mesh), 8, 1e-5);
  }
}

TEST(Subdivision, SharpnessGrowsFromSmoothToSharp) {
  double last = volume(refine(cube(), {4, {}}));
  EXPECT_NEAR(volume(refine(cube_with_creases(0), {4, {}})), last, 1e-6);
  for (const float sharpness : {0.5f, 1.0f, 2.0f, 3.0f, 10.0f}) {
    const double now = volume(refine(cube_with_creases(sharpness), {4, {}}));
    EXPECT_GT(now, last + 0.05) << sharpness;
    last = now;
  }
  SubdivisionCage cage = cube();
  EXPECT_GT(distance_to_vertices(refine(cage, {3, {}}), 1, 1, 1), 0.5);
  cage.vertex_creases = {{7, 10}};
  EXPECT_LT(distance_to_vertices(refine(cage, {3, {}}), 1, 1, 1), 1e-6);
  EXPECT_GT(distance_to_vertices(refine(cage, {3, {}}), -1, 1, 1), 0.5);
}

TEST(Subdivision, BordersFollowTheirRule) {
  // A border is a cubic B-spline: its vertices go to (a + 4 b + c) / 6.
  const Mesh round = refine(square(Boundary::kEdgeOnly), {0, {}});
  ASSERT_EQ(round.steps[0].size(), 4u);
  EXPECT_LT(distance_to_vertices(round, 1.0 / 6, 1.0 / 6, 0), 1e-6);
  EXPECT_LT(distance_to_vertices(round, 5.0 / 6, 1.0 / 6, 0), 1e-6);
  const Mesh sharp = refine(square(Boundary::kEdgeAndCorner), {3, {}});
  EXPECT_EQ(sharp.steps[0].size(), 81u);
  for (const double x : {0.0, 0.125, 1.0}) {
    for (const double y : {0.0, 0.375, 1.0}) EXPECT_LT(distance_to_vertices(sharp, x, y, 0), 1e-6);
  }
  EXPECT_THROW(refine(square(Boundary::kNone), {1, {}}), std::invalid_argument);
}

TEST(Subdivision, HolesAreLeftOutAndChangeNothingElse) {
  SubdivisionCage cage = cube();
  const Mesh whole = refine(cage, {3, {}});
  cage.holes = {1};  // +x
  const Mesh open = refine(cage, {3, {}});
  EXPECT_EQ(open.triangle_count(), whole.triangle_count() / 6 * 5);
  EXPECT_EQ(open.steps[0].size(), whole.steps[0].size() - 7 * 7);
  for (const Vec3f& p : open.steps[0].span())
    EXPECT_EQ(distance_to_vertices(whole, double{p.x}, double{p.y}, double{p.z}), 0);
  cage.holes = {0, 1, 2, 3, 4, 5};
  EXPECT_THROW(refine(cage, {3, {}}), std::invalid_argument);
}

TEST(Subdivision, AffineMapsOfTheCageAreAffineMapsOfTheSurface) {
  const auto map = [](Vec3f p) {
    return Vec3f{2 * p.x + 0.5f * p.y - p.z + 3, -p.x + 0.25f * p.z - 1, 0.5f * p.y + 4 * p.z + p.x};
  };
  for (SubdivisionCage cage : {cube(), grid(5, Boundary::kEdgeOnly), cube_with_creases(1.5f)}) {
    const Mesh plain = refine(cage, {3, {}});
    for (std::size_t v = 0; v < cage.steps[0].size(); ++v) cage.steps[0][v] = map(cage.steps[0][v]);
    const Mesh mapped = refine(cage, {3, {}});
    ASSERT_EQ(mapped.indices, plain.indices);
    for (std::size_t v = 0; v < plain.steps[0].size(); ++v) {
      const Vec3f p = map(plain.steps[0][v]), q = mapped.steps[0][v];
      EXPECT_LT(std::hypot(p.x - q.x, p.y - q.y, p.z - q.z), 2e-5f);
    }
  }
}

TEST(Subdivision, EachStepIsTheSurfaceOfItsCage) {
  const SubdivisionCage cage = moving_cube(5);
  const Mesh mesh = refine(cage, {3, {}});
  ASSERT_EQ(mesh.steps.size(), 5u);
  for (std::size_t s = 0; s < 5; ++s) {
    SubdivisionCage alone = cage;
    alone.steps = {cage.steps[s]};
    const Mesh still = refine(alone, {3, {}});
    EXPECT_EQ(still.indices, mesh.indices);
    EXPECT_TRUE(same_bits(still.steps[0], mesh.steps[s])) << s;
  }
}

TEST(Subdivision, TheSameBitsOnAnyNumberOfThreads) {
  const auto on_threads = [](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return refine(moving_cube(3), {5, {}});
  };
  const Mesh one = on_threads(1), two = on_threads(2);
  EXPECT_EQ(one.indices, two.indices);
  for (std::size_t s = 0; s < 3; ++s) EXPECT_TRUE(same_bits(one.steps[s], two.steps[s]));
}

TEST(Subdivision, ClosedSurfacesStayClosedAndOutward) {
  for (const SubdivisionCage& cage : {cube(), pyramid(), cube_with_creases(2)}) {
    for (unsigned level = 0; level <= 3; ++level) {
      const Mesh mesh = refine(cage, {level, {}});
      std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
      for (std::size_t i = 0; i < mesh.indices.size(); ++i)
        ++edges[{mesh.indices[i], mesh.indices[i % 3 == 2 ? i - 2 : i + 1]}];
      for (const auto& [edge, uses] : edges) {
        ASSERT_EQ(uses, 1);
        ASSERT_EQ(edges.count({edge.second, edge.first}), 1u);
      }
      EXPECT_GT(volume(mesh), 0.1);
      if (level > 0) {
        EXPECT_EQ(mesh.triangle_count(), cage.face_vertices.size() * 2 << (2 * (level - 1)));
      }
    }
  }
}

std::size_t weight_count(const SubdivisionCage& cage) {
  std::size_t count = 0;
  for (const subdivision::WeightedSums& stage : subdivision::refine_topology(cage, 3).stages)
    count += stage.weights.size();
  return count;
}

TEST(Subdivision, WorkGrowsLinearlyWithValenceAndCorners) {
  EXPECT_LT(weight_count(wheel(2000)), 21 * weight_count(wheel(100)));
  EXPECT_LT(weight_count(disc(2000)), 21 * weight_count(disc(100)));
  for (const std::uint32_t count : {300u, 5000u}) {
    EXPECT_EQ(refine(wheel(count), {3, {}}).triangle_count(), std::size_t{count} * 3 * 16 * 2);
    EXPECT_EQ(refine(disc(count), {3, {}}).triangle_count(), std::size_t{count} * 16 * 2);
  }
}

TEST(Subdivision, VerticesOfManyEdgesGoToTheirLimits) {
  // After one step by hand, with the heights of the centre alone: its n faces have a third of it, the edge
  // points (1 + 2 / 3) / 4; itself (1 - 2 / n) + 0 + 1 / 3 / n; then the mask of n edges.
  for (const double n : {7.0, 400.0, 3000.0}) {
    const Mesh mesh = refine(wheel(static_cast<std::uint32_t>(n)), {3, {}});
    const double centre = 1 - 2 / n + 1 / (3 * n), edge = 5.0 / 12, face = 1.0 / 3;
    const double limit = (n * centre + 4 * edge + face) / (n + 5);
    EXPECT_LT(distance_to_vertices(mesh, 0, 0, limit), 1e-6) << n;
    const Mesh flat = refine(disc(static_cast<std::uint32_t>(n)), {3, {}});
    EXPECT_LT(distance_to_vertices(flat, 0, 0, 0), 1e-6) << n;
  }
}

TEST(Subdivision, MoreEdgesOrCornersThanPossibleAreRefused) {
  EXPECT_NE(refusal(disc(65536)).find("face 0 of the cage has 65536 corners, but 3 to 65535 are possible"),
            std::string::npos);
  EXPECT_NE(
      refusal(wheel(65536)).find("vertex 0 of the cage has 65536 faces, but at most 65535 are possible"),
      std::string::npos);
}

double longest_edge(const Mesh& mesh) {
  double longest = 0;
  for (const VertexBuffer& p : mesh.steps) {
    for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f a = p[mesh.indices[t + k]], b = p[mesh.indices[t + (k + 1) % 3]];
        longest = std::max(longest, std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z));
      }
    }
  }
  return longest;
}

TEST(Subdivision, EdgeLengthsChooseTheLeastLevel) {
  SubdivisionCage cage = cube();
  cage.steps.push_back(cage.steps[0]);
  for (std::size_t v = 0; v < 8; ++v) cage.steps[1][v].x *= 20;  // only the last step needs the most
  for (unsigned level = 1; level <= 5; ++level) {
    const double here = longest_edge(refine(cage, {level, {}}));
    const double before = longest_edge(refine(cage, {level - 1, {}}));
    ASSERT_LT(here, before);
    const auto target = static_cast<float>(0.5 * (here + before));
    const Mesh mesh = refine(cage, {3, target});
    EXPECT_EQ(mesh.triangle_count(), std::size_t{12} << (2 * level));
  }
  for (const float target :
       {0.f, -1.f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e-9f})
    EXPECT_THROW(refine(grid(60, Boundary::kEdgeOnly), {3, target}), std::invalid_argument) << target;
}

TEST(Subdivision, BadCagesAreRefused) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  using Change = std::function<void(SubdivisionCage&)>;
  const std::vector<std::pair<const char*, Change>> cases{
      {"no faces",
       [](auto& c) {
         c.face_sizes.clear();
         c.face_vertices.clear();
       }},
      {"face 1 of the cage has 2 corners", [](auto& c) { c.face_sizes[1] = 2; }},
      {"more corners than the 24", [](auto& c) { c.face_sizes[5] = 5; }},
      {"have 24 corners, but 25 are given", [](auto& c) { c.face_vertices.push_back(0); }},
      {"has vertex 8, but there are only 8", [](auto& c) { c.face_vertices[3] = 8; }},
      {"face 0 of the cage has vertex 4 twice", [](auto& c) { c.face_vertices[0] = 4; }},
      {"0 steps", [](auto& c) { c.steps.clear(); }},
      {"4097 steps", [](auto& c) { c.steps.resize(4097, c.steps[0]); }},
      {"step 1 of the cage has 7 vertices", [](auto& c) { c.steps.emplace_back(7); }},
      {"the sharpness -1",
       [](auto& c) {
         c.edge_creases = {{0, 1, -1}};
       }},
      {"the sharpness nan",
       [](auto& c) {
         c.vertex_creases = {{0, kNan}};
       }},
      {"a crease of the cage has vertex 9",
       [](auto& c) {
         c.edge_creases = {{0, 9, 1}};
       }},
      {"a vertex crease of the cage has vertex 8",
       [](auto& c) {
         c.vertex_creases = {{8, 1}};
       }},
      {"between vertices 0 and 7, which no edge joins",
       [](auto& c) {
         c.edge_creases = {{0, 7, 1}};
       }},
      {"face 6 of the cage is a hole", [](auto& c) { c.holes = {6}; }}};
  EXPECT_EQ(refusal(cube()), "");
  for (const auto& [because, change] : cases) {
    SubdivisionCage cage = cube();
    change(cage);
    EXPECT_NE(refusal(cage).find(because), std::string::npos) << refusal(cage) << "\nnot: " << because;
  }
  EXPECT_NE(refusal(cube(), {11, {}}).find("10 times, not 11"), std::string::npos);
  EXPECT_NE(refusal(grid(20, Boundary::kEdgeOnly), {10, {}}).find("at level 10"), std::string::npos);
}

TEST(Subdivision, DegeneratePartsAreTakenOut) {
  SubdivisionCage cage = cube_with_creases(2);
  cage.holes = {1};
  const Mesh open = refine(cage, {2, {}});
  DegenerateParts parts = take_out_degenerate_parts(cage);
  EXPECT_EQ(parts.faces + parts.creases, 0u);
  EXPECT_EQ(parts.numbers, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  // Three faces before the second and one behind the last, each in another way; and two diagonals.
  const std::vector<std::uint32_t> none{5, 6, 0, 1, 0, 2, 3, 3};
  cage.face_vertices.insert(cage.face_vertices.begin() + 4, none.begin(), none.end());
  cage.face_sizes = {4, 2, 3, 3, 4, 4, 4, 4, 4, 0};
  cage.holes = {4, 2, 9};
  cage.edge_creases.insert(cage.edge_creases.begin(), {{0, 7, 1}, {5, 6, 1}});
  EXPECT_NE(refusal(cage), "");
  parts = take_out_degenerate_parts(cage);
  EXPECT_EQ(parts.faces, 4u);
  EXPECT_EQ(parts.creases, 2u);
  EXPECT_EQ(parts.numbers, (std::vector<std::uint32_t>{0, 4, 5, 6, 7, 8}));
  EXPECT_EQ(cage.holes, (std::vector<std::uint32_t>{1}));
  const Mesh again = refine(cage, {2, {}});
  EXPECT_EQ(again.indices, open.indices);
  EXPECT_TRUE(same_bits(again.steps[0], open.steps[0]));
}

TEST(Subdivision, CagesThatShowNothingAreOfAKindOfTheirOwn) {
  SubdivisionCage cage = cube();
  cage.holes = {0, 1, 2, 3, 4, 5};
  EXPECT_THROW(refine(cage, {}), InvisibleCage);
  EXPECT_THROW(refine(square(Boundary::kNone), {}), InvisibleCage);
}

TEST(Subdivision, LoopSurfacesAndTheFacesThatTrianglesComeOf) {
  SubdivisionCage cage;
  cage.scheme = SubdivisionCage::Scheme::kLoop;
  cage.face_sizes = {3, 3, 3, 3};
  cage.face_vertices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  cage.steps = {buffer_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})};
  const Mesh mesh = refine(cage, {2, {}});
  EXPECT_EQ(mesh.triangle_count(), 4u * 16);
  for (std::uint32_t face = 0; face < 4; ++face) EXPECT_EQ(std::ranges::count(mesh.faces, face), 16);
  // Loop 1987: where three edges meet, the limit is 2/5 of the vertex and 1/5 of each neighbour.
  EXPECT_LT(distance_to_vertices(mesh, 0.2, 0.2, 0.2), 1e-6);
  EXPECT_LT(distance_to_vertices(mesh, 0.4, 0.2, 0.2), 1e-6);
  cage.face_sizes = {4, 4, 4};
  EXPECT_THROW(refine(cage, {}), std::invalid_argument);
}

TEST(Subdivision, EdgesOfThreeFacesAreTakenAsSharp) {
  SubdivisionCage cage;
  cage.face_sizes = {3, 3, 3};
  cage.face_vertices = {0, 1, 2, 1, 0, 3, 0, 1, 4};
  cage.steps = {buffer_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}})};
  const Mesh mesh = refine(cage, {3, {}});
  EXPECT_EQ(mesh.triangle_count(), 9u * 16 * 2);
  EXPECT_LT(distance_to_vertices(mesh, 0.5, 0, 0), 1e-6);
}

}  // namespace
}  // namespace stbvh::harness
