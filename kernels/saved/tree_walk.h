/// The block of a tree in the order of a walk: put into it, and checked that it is in it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh_table.h"
#include "stored_tree.h"

namespace stbvh {

/// Nodes and leaves of a tree, each node followed by the subtrees of its children, indexed leaves behind all.
struct OrderedBlock {
  std::vector<std::byte> bytes;
  std::size_t indexed_bytes = 0;
  Link root = 0;
};
OrderedBlock in_order(const StoredTree& tree);

/// Throws BadStructureFile unless `block` is a tree as in_order() makes it, whose every link, index and time
/// leads to something of `table`. `vertices` are those of each record's mesh, `triangles` likewise. Returns
/// what the tree consists of.
TreeCounts checked_counts(std::span<const std::byte> block, std::size_t indexed_bytes, const NodeSlot& root,
                          const MeshTable& table, std::span<const MeshView> mesh_of_record);

}  // namespace stbvh
