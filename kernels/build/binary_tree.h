/// The binary tree that the splits make, before it is collapsed into nodes of eight children.
#pragma once

#include <array>
#include <cstdint>

#include "build/linear_bounds.h"
#include "build/mesh_set.h"
#include "build/meshlet.h"
#include "layout/layout.h"

namespace stbvh {

/// A meshlet over the time range of its node.
struct BinaryLeaf {
  const Meshlet* meshlet;
  std::uint32_t mesh;
  BuildMesh::SegmentRange segments;  ///< {0, 0} and no motion where the mesh is static
  bool is_indexed;                   ///< set by the encoder
};

struct BinaryNode {
  LinearBounds bounds;
  ClosedTimeRange range;
  BinaryNode* children[2];  ///< null in a leaf
  BinaryLeaf* leaf;         ///< null in an inner node

  /// cost[i]: least expected cost of the subtree as at most i + 1 children of a node above it. Filled by
  /// collapse.
  std::array<float, kWidth> cost;
  /// How cost[i] is reached: the number of children that come from children[0]; 0: as cost[i-1], or for i = 0
  /// as a node (or leaf) of its own.
  std::array<std::uint8_t, kWidth> from_left;
  std::uint8_t own_from_left;  ///< of the eight children that the node has as a node of its own

  std::size_t subtree_leaves;
  std::size_t units;  ///< of the encoded subtree; filled by the encoder

  bool is_leaf() const { return leaf != nullptr; }
};

}  // namespace stbvh
