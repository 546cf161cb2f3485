/// Which triangles of a mesh a ray may come near: a binary tree of boxes, for the oracle alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "harness/oracle/ray_triangle.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// One order of the valid triangles for all segments, and for each segment the boxes swept by the tree's
/// nodes over it. The tree is implicit: node i has children 2i+1 and 2i+2, the leaves share the order evenly.
class MeshCull {
 public:
  /// `split` false keeps one leaf with an unbounded box: no cull at all.
  MeshCull(const Mesh& mesh, bool split);

  /// Distances are enlarged by this: more than any triangle of the mesh can move within rounding.
  double padding(const OracleRay& ray, const TriangleMotion& motion) const;

  /// A t for rays that pass.
  static constexpr double kPasses = std::numeric_limits<double>::infinity();

  /// Smallest t at which `ray` may hit something of the mesh, or kPasses.
  double nearest(const OracleRay& ray, const TriangleMotion& motion) const;

  /// Calls visit(prim) for each triangle that `ray` may come near, before `limit()` (an upper bound of t,
  /// which may shrink).
  template <class Limit, class Visit>
  void visit(const OracleRay& ray, const TriangleMotion& motion, const Limit& limit,
             const Visit& visit) const;

 private:
  void order_triangles(const Mesh& mesh, std::size_t node, std::size_t depth);
  void bound(const Mesh& mesh, std::size_t step);
  std::size_t first_of(std::size_t leaf) const;
  double entry(const OracleRay& ray, const TriangleMotion& motion, std::size_t node, double padding) const;

  std::size_t depth_ = 0;  ///< the tree has 2^depth_ leaves
  double largest_ = 0;     ///< length of the longest position vector
  std::vector<std::uint32_t> prims_;
  std::vector<std::vector<Box3f>> boxes_;  ///< of each step: of each node
};

template <class Limit, class Visit>
void MeshCull::visit(const OracleRay& ray, const TriangleMotion& motion, const Limit& limit,
                     const Visit& visit) const {
  struct Entry {
    std::size_t node;
    double t;
  };
  const double pad = padding(ray, motion);
  const std::size_t first_leaf = (std::size_t{1} << depth_) - 1;
  Entry stack[64];
  std::size_t size = 0;
  const auto push = [&](std::size_t node, double t) {
    if (t < kPasses && t <= limit()) stack[size++] = {node, t};
  };
  push(0, entry(ray, motion, 0, pad));
  while (size > 0) {
    const Entry top = stack[--size];
    if (top.t > limit()) continue;
    if (top.node >= first_leaf) {
      const std::size_t leaf = top.node - first_leaf;
      for (std::size_t i = first_of(leaf); i < first_of(leaf + 1); ++i) visit(prims_[i]);
      continue;
    }
    const double left = entry(ray, motion, 2 * top.node + 1, pad);
    const double right = entry(ray, motion, 2 * top.node + 2, pad);
    const bool left_first = left <= right;
    push(2 * top.node + (left_first ? 2 : 1), left_first ? right : left);
    push(2 * top.node + (left_first ? 1 : 2), left_first ? left : right);
  }
}

}  // namespace stbvh::harness
