/// Looking at a tree: its nodes and leaves, where they are at a time, and when they are there at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "stbvh/mesh_view.h"

namespace stbvh {

enum class NodeKind {
  kStatic,           ///< a node whose children stand still
  kLinear,           ///< a node whose children move linearly, all over the same time range
  kSpatialTemporal,  ///< a node whose children have time ranges of their own
  kInlineLeaf,       ///< triangles with their vertices
  kIndexedLeaf,      ///< triangles with vertex indices
};

inline bool is_leaf(NodeKind kind) {
  return kind == NodeKind::kInlineLeaf || kind == NodeKind::kIndexedLeaf;
}

/// A box that moves linearly; its faces are those that rays are tested against, before the padding that a
/// ray's own rounding needs.
struct MovingBox {
  Box3f at_begin;  ///< at `begin`
  Box3f slope;     ///< change of each face in a unit of time
  float begin = 0;

  Box3f at(float time) const;
};

/// A node or leaf as a walk through the tree meets it.
struct TreeNode {
  NodeKind kind = NodeKind::kStatic;
  std::size_t level = 0;  ///< 0: the root
  TimeRange time_range;   ///< closed: at other times no ray comes here
  bool has_own_range =
      false;      ///< shorter than its parent's: after a temporal split, or a mesh that is there for a part
  MovingBox box;  ///< holds over time_range for everything below; of the root: over all boxes below
  std::uint32_t geom_id = 0;                  ///< of leaves
  std::span<const std::uint32_t> prim_ids{};  ///< of leaves: the triangles of geom_id; valid during the visit
};

/// Told of nodes before those below them, siblings in the order in which occlusion rays try them.
class NodeVisitor {
 public:
  virtual ~NodeVisitor() = default;

  /// Returns whether to visit what is below `node`.
  virtual bool enter(const TreeNode& node) = 0;
  /// Called after what is below `node`, for each node that was entered.
  virtual void leave(const TreeNode&) {}
};

}  // namespace stbvh
