#include "harness/scenes/subdivision/subdivision.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/subdivision/cage_check.h"
#include "harness/scenes/subdivision/cage_topology.h"

namespace stbvh::harness {
namespace subdivision {
namespace {

struct Point {
  double x = 0, y = 0, z = 0;
};

/// What the rows from `begin` to `end` sum up, on many threads.
void apply_rows(const WeightedSums& sums, std::size_t begin, std::size_t end,
                const std::vector<Point>& columns, std::vector<Point>& rows) {
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(begin, end, 1024), [&](const Range& range) {
    for (std::size_t row = range.begin(); row < range.end(); ++row) {
      Point sum;
      for (std::size_t k = sums.first[row]; k < sums.first[row + 1]; ++k) {
        const std::size_t column = sums.columns[k];
        const Point& p = column < sums.own ? rows[column] : columns[column - sums.own];
        sum = {sum.x + sums.weights[k] * p.x, sum.y + sums.weights[k] * p.y, sum.z + sums.weights[k] * p.z};
      }
      rows[row] = sum;
    }
  });
  check_cancelled();
}

std::vector<Point> product(const WeightedSums& sums, const std::vector<Point>& columns) {
  std::vector<Point> rows(sums.size());
  apply_rows(sums, 0, sums.own, columns, rows);
  apply_rows(sums, sums.own, sums.size(), columns, rows);
  return rows;
}

/// One step of the mesh; in double, rounded once.
VertexBuffer limit_positions(const CageTopology& topology, const VertexBuffer& cage) {
  std::vector<Point> points;
  points.reserve(cage.size());
  for (const Vec3f& p : cage.span()) points.push_back({double{p.x}, double{p.y}, double{p.z}});
  for (const WeightedSums& stage : topology.stages) points = product(stage, points);
  VertexBuffer result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    result[i] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }
  return result;
}

/// There is about one vertex for each face.
bool is_possible(const SubdivisionCage& cage, unsigned level) {
  const std::size_t faces = refined_face_count(cage, level);
  return faces <= kMaxRefinedFaces && faces * cage.steps.size() * sizeof(Vec3f) <= kMaxRefinedBytes;
}

Mesh refine_to_level(const SubdivisionCage& cage, unsigned level) {
  CageTopology topology = refine_topology(cage, level);
  Mesh mesh;
  mesh.steps.resize(cage.steps.size());
  for_all(cage.steps.size(),
          [&](std::size_t s) { mesh.steps[s] = limit_positions(topology, cage.steps[s]); });
  mesh.indices = std::move(topology.indices);
  mesh.faces = std::move(topology.faces);
  return mesh;
}

double longest_edge(const Mesh& mesh) {
  double longest = 0;
  for (const VertexBuffer& step : mesh.steps) {
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
      const Vec3f& a = step[mesh.indices[i]];
      const Vec3f& b = step[mesh.indices[i % 3 == 2 ? i - 2 : i + 1]];
      longest = std::max(longest, std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z));
    }
  }
  return longest;
}

/// Vertices stay where they are as the level grows, so a path of 2^(k + 1) edges joins the ends of each edge
/// k levels later, and one of them is at least its share of the distance.
bool is_out_of_reach(double longest, unsigned levels_left, float target) {
  return std::ldexp(longest, -static_cast<int>(levels_left) - 1) >= double{target};
}

Mesh refine_to_edge_length(const SubdivisionCage& cage, float target) {
  if (!(target > 0) || !std::isfinite(target)) fail("edges must be longer than 0, not below {}", target);
  unsigned finest = kMaxRefinementLevel;
  while (finest > 0 && !is_possible(cage, finest)) --finest;
  for (unsigned level = 0; level <= finest; ++level) {
    Mesh mesh = refine_to_level(cage, level);
    const double longest = longest_edge(mesh);
    if (longest < double{target}) return mesh;
    if (is_out_of_reach(longest, finest - level, target)) break;
  }
  fail("level {} is the finest possible, but is too coarse for edges below {}", finest, target);
}

}  // namespace
}  // namespace subdivision

Mesh refine(const SubdivisionCage& cage, const RefinementTarget& target) {
  using namespace subdivision;
  check_cage(cage);
  if (!is_possible(cage, 0)) fail("the cage has {} faces, which is too many", cage.face_sizes.size());
  if (target.edge_length) return refine_to_edge_length(cage, *target.edge_length);
  if (target.level > kMaxRefinementLevel) {
    fail("a cage can be refined {} times, not {}", kMaxRefinementLevel, target.level);
  }
  if (!is_possible(cage, target.level)) {
    fail("at level {} the cage has {} faces in {} steps, which is more than {} faces or {} GB", target.level,
         refined_face_count(cage, target.level), cage.steps.size(), kMaxRefinedFaces, kMaxRefinedBytes >> 30);
  }
  return refine_to_level(cage, target.level);
}

}  // namespace stbvh::harness
