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

/// Calls store(row, sum of its weighted columns) for each row, on many threads.
template <class Column, class Store>
void apply(const WeightedSums& sums, const Column& column, const Store& store) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sums.size(), 1024), [&](const tbb::blocked_range<
                                                                               std::size_t>& range) {
    for (std::size_t row = range.begin(); row < range.end(); ++row) {
      Point sum;
      for (std::size_t k = sums.first[row]; k < sums.first[row + 1]; ++k) {
        const Point p = column(sums.columns[k]);
        sum = {sum.x + sums.weights[k] * p.x, sum.y + sums.weights[k] * p.y, sum.z + sums.weights[k] * p.z};
      }
      store(row, sum);
    }
  });
  check_cancelled();
}

/// One step of the mesh; in double, rounded once.
VertexBuffer limit_positions(const CageTopology& topology, const VertexBuffer& cage) {
  std::vector<Point> refined(topology.refined.size());
  apply(
      topology.refined,
      [&](std::uint32_t i) {
        return Point{double{cage[i].x}, double{cage[i].y}, double{cage[i].z}};
      },
      [&](std::size_t row, Point p) { refined[row] = p; });
  VertexBuffer result(topology.limit.size());
  apply(
      topology.limit, [&](std::uint32_t i) { return refined[i]; },
      [&](std::size_t row, Point p) {
        result[row] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
      });
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
