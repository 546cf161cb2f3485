/// What a tree consists of, or what a change adds to that.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "layout/layout.h"
#include "stbvh/structure.h"

namespace stbvh {

struct TreeCounts {
  std::array<std::int64_t, 3> nodes{};  ///< by LinkKind
  std::array<std::int64_t, 3> node_children{};
  std::int64_t inline_leaves = 0, indexed_leaves = 0, leaf_triangles = 0;
  std::int64_t leaf_units = 0;  ///< of inline leaves
  double expected_area = 0.0;   ///< SA'(bounds) * T(range) of all children of nodes: what a ray has to do
  std::size_t depth = 0;

  void add(const TreeCounts& other) {
    for (std::size_t kind = 0; kind < 3; ++kind) {
      nodes[kind] += other.nodes[kind];
      node_children[kind] += other.node_children[kind];
    }
    inline_leaves += other.inline_leaves;
    indexed_leaves += other.indexed_leaves;
    leaf_triangles += other.leaf_triangles;
    leaf_units += other.leaf_units;
    expected_area += other.expected_area;
    depth = std::max(depth, other.depth);
  }

  void add_node(LinkKind kind, std::size_t children, std::int64_t times = 1) {
    nodes[static_cast<std::size_t>(kind)] += times;
    node_children[static_cast<std::size_t>(kind)] += times * static_cast<std::int64_t>(children);
  }

  void enter_in(BuildStatistics& statistics) const {
    for (std::size_t kind = 0; kind < 3; ++kind) {
      statistics.nodes[kind] = static_cast<std::size_t>(nodes[kind]);
      statistics.node_children[kind] = static_cast<std::size_t>(node_children[kind]);
    }
    statistics.inline_leaves = static_cast<std::size_t>(inline_leaves);
    statistics.indexed_leaves = static_cast<std::size_t>(indexed_leaves);
    statistics.leaf_triangles = static_cast<std::size_t>(leaf_triangles);
    statistics.depth = depth;
  }
};

}  // namespace stbvh
