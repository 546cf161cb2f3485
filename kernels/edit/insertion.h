/// A subtree hung into a tree where rays have the least to do for it.
#pragma once

#include <cstddef>
#include <vector>

#include "builder/tree_counts.h"
#include "edit/unit_space.h"
#include "layout/node_slots.h"

namespace stbvh {

/// Most units that an insertion takes beside those of the subtree itself.
inline constexpr std::size_t kInsertionUnits = (kMaxLevels + 2) * sizeof(SpatialTemporalNode) / kUnitBytes;

class Insertion {
 public:
  /// `root` is that of a tree in the block at `data`; `space` has kInsertionUnits.
  Insertion(std::byte* data, UnitSpace& space, const NodeSlot& root)
      : data_(data), space_(space), root_(root) {}

  void insert(const NodeSlot& subtree);

  const NodeSlot& root() const { return root_; }
  const TreeCounts& change() const { return change_; }
  /// Nodes from the root to the subtree.
  std::size_t levels() const { return levels_ + (pushes_down_ ? 1 : 0); }
  /// Whether a part of the tree has become one level deeper.
  bool pushes_down() const { return pushes_down_; }

 private:
  /// A node on the way down.
  struct Level {
    NodeSlots node;
    Link link;
    std::size_t chosen = 0;  ///< the child that is the next level
  };

  std::vector<Level> way_to(const NodeSlot& subtree) const;
  NodeSlot paired(const NodeSlot& a, const NodeSlot& b, const ClosedTimeRange& range);
  /// Writes the node to where `link` is, or to a larger place.
  Link replace(Link link, const NodeSlots& before, const NodeSlots& after);

  std::byte* data_;
  UnitSpace& space_;
  NodeSlot root_;
  TreeCounts change_;
  std::size_t levels_ = 0;
  bool pushes_down_ = false;
};

}  // namespace stbvh
