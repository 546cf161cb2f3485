/// A tree as it lies in memory, with all that a change of it needs to know.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "block.h"
#include "builder/tree_counts.h"
#include "edit/unit_space.h"
#include "layout/node_slots.h"
#include "mesh_table.h"
#include "stbvh/structure.h"

namespace stbvh {

struct StoredTree {
  StoredTree(const BuildSettings& with, const BuildCallbacks& callbacks, std::size_t bytes)
      : StoredTree(with, Block(callbacks, bytes)) {}
  StoredTree(const BuildSettings& with, Block own)
      : settings(with),
        block(std::move(own)),
        space(block.bytes() / kUnitBytes, block.bytes() / kUnitBytes) {}

  BuildSettings settings;
  Block block;
  UnitSpace space;  ///< of the block
  MeshTable meshes;
  bool is_empty = false;
  NodeSlot root{};  ///< bounds are those of everything
  TreeCounts counts;
  /// Of the leaves that a tree built anew would have, as far as that is known: what `counts` has is held
  /// against it.
  double usual_area = 0.0;
  std::size_t temporal_splits = 0;
  std::size_t indexed_leaf_bytes = 0;

  std::size_t bytes() const { return block.bytes() + meshes.bytes(); }
};

/// A structure around a tree that was not built here.
std::unique_ptr<Structure> structure_of(StoredTree tree, std::size_t wanted_bytes);

}  // namespace stbvh
