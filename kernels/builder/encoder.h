/// From the binary tree to the bytes of a structure: which leaves are inline, which nodes become the children
/// of which, and where each of them stands. layout/ writes them.
#pragma once

#include <span>
#include <vector>

#include "builder/binary_node.h"
#include "builder/build_context.h"
#include "builder/tree_counts.h"
#include "layout/layout.h"

namespace stbvh {

class Encoder {
 public:
  /// Enters in the nodes below `root` (null: there are none) what has been chosen, and how many bytes they
  /// take: all leaves are inline, or in `most_bytes` as many as rays profit from most.
  Encoder(BuildContext& context, BinaryNode* root, std::size_t most_bytes);

  /// Bytes that encode() writes; 0 for an empty tree. More than `most_bytes` where the tree takes more even
  /// with indexed leaves alone.
  std::size_t bytes() const { return units_ * kUnitBytes + indexed_count_ * kIndexedLeafBytes; }

  /// Writes nodes and leaves to the block at `data`, from number `first_unit` of its units on (bytes() of it,
  /// aligned to kUnitBytes), each node followed by its children's subtrees in the order in which occlusion
  /// rays try them, indexed leaves behind all. Leaves name the mesh `records[i]` for the i-th. Returns the
  /// root's link.
  Link encode(std::byte* data, std::size_t first_unit, std::span<const std::uint32_t> records) const;

  /// What measuring the tree has found.
  const TreeCounts& counts() const { return counts_; }
  std::size_t leaf_bytes() const {
    return static_cast<std::size_t>(counts_.leaf_units) * kUnitBytes + indexed_count_ * kIndexedLeafBytes;
  }

 private:
  /// Chooses which leaves are indexed, so that all leaves take at most `most_bytes`; numbers the meshlets of
  /// those.
  void choose_leaves(BinaryNode& root, std::size_t most_bytes);
  TreeCounts measure(BinaryNode& node) const;
  /// Where the tree is written to.
  struct Target {
    std::byte* data;
    std::size_t first_indexed;  ///< unit of the first indexed leaf
    std::span<const std::uint32_t> records;
  };
  Link encode_node(const BinaryNode& node, const Target& target, std::size_t unit) const;
  std::size_t leaf_units(const BinaryLeaf& leaf) const;
  std::size_t leaf_steps(const BinaryLeaf& leaf) const;
  std::size_t meshlet_number(const BinaryLeaf& leaf) const;

  BuildContext& context_;
  const BinaryNode* root_;
  TreeCounts counts_;
  std::size_t units_ = 0;  ///< of nodes and inline leaves
  /// Indexed leaves stand behind them, one for each meshlet: leaves of all its time ranges are the same.
  std::vector<std::size_t> first_meshlet_;  ///< of each mesh, in the next
  std::vector<std::uint32_t> indexed_;      ///< of each meshlet: number of its indexed leaf, or kNone
  std::size_t indexed_count_ = 0;
};

}  // namespace stbvh
