/// Nodes of the binary tree that the splits make, before it is collapsed into nodes of eight children. Two of
/// them stand for each leaf until everything is encoded: they are most of what a build needs beside the
/// structure, and so are kept small.
#pragma once

#include <cstddef>
#include <cstdint>

#include "builder/build_mesh.h"
#include "layout/closed_time_range.h"
#include "layout/linear_bounds.h"
#include "layout/meshlet.h"

namespace stbvh {

/// What leaves and inner nodes have in common; is_leaf() tells them apart.
struct BinaryNode {
  PackedBounds packed_bounds;
  ClosedTimeRange range;
  std::uint32_t subtree_leaves;
  std::uint32_t units;  ///< of the encoded subtree; filled by the encoder

  bool is_leaf() const { return subtree_leaves == 1; }
  LinearBounds bounds() const { return packed_bounds.unpacked(); }
};

/// A meshlet over the time range of its node.
struct BinaryLeaf : BinaryNode {
  const Meshlet* meshlet;
  std::uint32_t mesh;
  BuildMesh::SegmentRange segments;  ///< {0, 0} and no motion where the mesh is static
  bool is_indexed;                   ///< set by the encoder
};

/// How a node shares out slots to its two subtrees; four bits for each number of slots.
class SlotShares {
 public:
  /// Of `slots`, 2 to 8, the number that child(0) gets where the node is replaced by its children; 0: it
  /// is better off with one slot less.
  std::size_t from_left(std::size_t slots) const { return bits_ >> (4 * (slots - 2)) & 7u; }
  void set_from_left(std::size_t slots, std::size_t count) { set(slots - 2, count); }
  /// Of the eight children that it has as a node of its own.
  std::size_t own_from_left() const { return bits_ >> (4 * kOwn) & 7u; }
  void set_own_from_left(std::size_t count) { set(kOwn, count); }

 private:
  static constexpr std::size_t kOwn = kWidth - 1;
  void set(std::size_t place, std::size_t count) {
    bits_ |= static_cast<std::uint32_t>(count) << (4 * place);
  }

  std::uint32_t bits_ = 0;
};

struct BinaryInner : BinaryNode {
  SlotShares shares;

  BinaryNode& child(std::size_t i) { return *children_[i]; }
  const BinaryNode& child(std::size_t i) const { return *children_[i]; }
  void set_children(BinaryNode& left, BinaryNode& right) {
    children_[0] = &left;
    children_[1] = &right;
  }

 private:
  BinaryNode* children_[2];
};

static_assert(sizeof(BinaryLeaf) == 88 && sizeof(BinaryInner) == 88);

inline const BinaryLeaf& as_leaf(const BinaryNode& node) {
  return static_cast<const BinaryLeaf&>(node);
}
inline BinaryLeaf& as_leaf(BinaryNode& node) {
  return static_cast<BinaryLeaf&>(node);
}
inline const BinaryInner& as_inner(const BinaryNode& node) {
  return static_cast<const BinaryInner&>(node);
}
inline BinaryInner& as_inner(BinaryNode& node) {
  return static_cast<BinaryInner&>(node);
}

}  // namespace stbvh
