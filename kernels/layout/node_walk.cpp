#include "layout/node_walk.h"

namespace stbvh {
namespace {

/// The planes of child `i`, and their slopes where the node has any.
MovingBox child_box(const float (&planes)[kPlanes][kWidth], const float (*slopes)[kWidth], float begin,
                    std::size_t i) {
  const auto box_of = [i](const float(*faces)[kWidth]) {
    return Box3f{{faces[kLowerX][i], faces[kLowerY][i], faces[kLowerZ][i]},
                 {faces[kUpperX][i], faces[kUpperY][i], faces[kUpperZ][i]}};
  };
  return {box_of(planes), slopes == nullptr ? Box3f{{0, 0, 0}, {0, 0, 0}} : box_of(slopes), begin};
}

/// Calls `use` with each child of `node`, as a node still without kind, and the link to it.
template <typename Node, typename Use>
void for_each_child(const Node& node, const TreeNode& parent, const Use& use) {
  for (std::size_t i = 0; i < kWidth; ++i) {
    if (!(node.planes[kLowerX][i] <= node.planes[kUpperX][i])) continue;  // an empty slot
    TreeNode child;
    child.level = parent.level + 1;
    child.time_range = parent.time_range;
    if constexpr (requires { node.time_last; }) {
      child.time_range = {node.time_begin[i], node.time_last[i]};
      child.box = child_box(node.planes, node.slopes, node.time_begin[i], i);
    } else if constexpr (requires { node.slopes; }) {
      child.box = child_box(node.planes, node.slopes, node.time_begin, i);
    } else {
      child.box = child_box(node.planes, nullptr, 0, i);
    }
    child.has_own_range =
        child.time_range.begin != parent.time_range.begin || child.time_range.end != parent.time_range.end;
    use(node.children[i], child);
  }
}

template <typename Use>
void for_each_child(LinkKind kind, const std::byte* data, const TreeNode& parent, const Use& use) {
  if (kind == LinkKind::kStaticNode) {
    for_each_child(*reinterpret_cast<const StaticNode*>(data), parent, use);
  } else if (kind == LinkKind::kLinearNode) {
    for_each_child(*reinterpret_cast<const LinearNode*>(data), parent, use);
  } else {
    for_each_child(*reinterpret_cast<const SpatialTemporalNode*>(data), parent, use);
  }
}

class Walk {
 public:
  Walk(const StructureView& structure, NodeVisitor& visitor) : structure_(structure), visitor_(visitor) {}

  void visit(Link link, TreeNode node) {
    const std::byte* data = structure_.data + std::size_t{link & kLinkOffsetMask} * kUnitBytes;
    const auto kind = static_cast<LinkKind>(link >> kLinkKindShift);
    if (kind == LinkKind::kLeaf) return visit_leaf(*reinterpret_cast<const LeafHeader*>(data), node);
    node.kind = static_cast<NodeKind>(kind);
    if (node.level == 0) {  // no node keeps its box: those of its children are what there is
      for_each_child(kind, data, node, [&](Link, const TreeNode& child) {
        node.box.at_begin.extend(child.box.at(child.time_range.begin));
        node.box.at_begin.extend(child.box.at(child.time_range.end));
      });
    }
    if (!visitor_.enter(node)) return;
    for_each_child(kind, data, node, [&](Link to, const TreeNode& child) { visit(to, child); });
    visitor_.leave(node);
  }

 private:
  void visit_leaf(const LeafHeader& leaf, TreeNode& node) {
    node.kind = leaf.indexed != 0 ? NodeKind::kIndexedLeaf : NodeKind::kInlineLeaf;
    node.geom_id = structure_.meshes[leaf.mesh].geom_id;
    node.prim_ids = {leaf.prim_ids, leaf.triangle_count};
    if (visitor_.enter(node)) visitor_.leave(node);
  }

  const StructureView& structure_;
  NodeVisitor& visitor_;
};

}  // namespace

Box3f MovingBox::at(float time) const {
  const float elapsed = time - begin;
  const auto moved = [elapsed](const Vec3f& p, const Vec3f& v) {
    return Vec3f{p.x + elapsed * v.x, p.y + elapsed * v.y, p.z + elapsed * v.z};
  };
  return {moved(at_begin.lower, slope.lower), moved(at_begin.upper, slope.upper)};
}

void walk_nodes(const StructureView& structure, NodeVisitor& visitor) {
  if (structure.empty) return;
  static_assert(static_cast<int>(NodeKind::kStatic) == static_cast<int>(LinkKind::kStaticNode) &&
                static_cast<int>(NodeKind::kLinear) == static_cast<int>(LinkKind::kLinearNode) &&
                static_cast<int>(NodeKind::kSpatialTemporal) ==
                    static_cast<int>(LinkKind::kSpatialTemporalNode));
  TreeNode root;
  root.time_range = {structure.time_begin, structure.time_last};
  root.has_own_range = false;
  root.box.at_begin = {{structure.lower[0], structure.lower[1], structure.lower[2]},
                       {structure.upper[0], structure.upper[1], structure.upper[2]}};
  root.box.slope = {{0, 0, 0}, {0, 0, 0}};
  Walk(structure, visitor).visit(structure.root, root);
}

}  // namespace stbvh
