#include "saved/tree_walk.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>
#include <type_traits>

#include "builder/mbsah.h"
#include "layout/leaf_segment.h"
#include "stbvh/saved_structure.h"

namespace stbvh {

namespace {

constexpr std::size_t kParallelLevels = 4;

/// Writes a tree anew, in order.
class Ordering {
 public:
  Ordering(const StoredTree& tree, std::vector<std::byte>& nodes) : tree_(tree), nodes_(nodes) {}

  /// Returns where it is now. Indexed leaves are numbered as they are met, as long as their places are not
  /// known.
  Link write(Link link, const ClosedTimeRange& range) {
    const std::byte* const data = tree_.block.data() + unit_of(link) * kUnitBytes;
    const std::size_t place = nodes_.size();
    if (kind_of(link) == LinkKind::kLeaf) {
      LeafHeader leaf;
      std::memcpy(&leaf, data, sizeof leaf);
      if (leaf.indexed != 0) {
        const std::size_t number = places_.try_emplace(unit_of(link), places_.size()).first->second;
        return make_link(LinkKind::kLeaf, kFirstIndexed + number);
      }
      const std::size_t bytes = inline_leaf_bytes(steps_of(leaf, tree_.meshes.record(leaf.mesh), range));
      nodes_.insert(nodes_.end(), data, data + bytes);
      return make_link(LinkKind::kLeaf, place / kUnitBytes);
    }
    NodeSlots node = read_node(kind_of(link), data, range);
    nodes_.resize(place + node_units(node.kind()) * kUnitBytes);
    for (NodeSlot& child : node.used()) child.link = write(child.link, child.range);
    write_node(node, nodes_.data() + place);
    return make_link(node.kind(), place / kUnitBytes);
  }

  /// Appends the indexed leaves, in the order in which they were; returns their bytes.
  std::size_t write_indexed_leaves() {
    ranks_.resize(places_.size());
    std::size_t rank = 0;
    first_indexed_ = nodes_.size() / kUnitBytes;
    for (const auto& [unit, number] : places_) {
      ranks_[number] = rank++;
      const std::byte* const data = tree_.block.data() + unit * kUnitBytes;
      nodes_.insert(nodes_.end(), data, data + kIndexedLeafBytes);
    }
    return rank * kIndexedLeafBytes;
  }
  /// Now that their places are known.
  void link_indexed_leaves(Link root, const ClosedTimeRange& range) {
    if (kind_of(root) == LinkKind::kLeaf) return;
    std::byte* const data = nodes_.data() + unit_of(root) * kUnitBytes;
    NodeSlots node = read_node(kind_of(root), data, range);
    for (NodeSlot& child : node.used()) {
      child.link = final_link(child.link);
      if (kind_of(child.link) != LinkKind::kLeaf) link_indexed_leaves(child.link, child.range);
    }
    write_node(node, data);
  }
  Link final_link(Link link) const {
    if (kind_of(link) != LinkKind::kLeaf || unit_of(link) < kFirstIndexed) return link;
    const std::size_t rank = ranks_[unit_of(link) - kFirstIndexed];
    return make_link(LinkKind::kLeaf, first_indexed_ + rank * (kIndexedLeafBytes / kUnitBytes));
  }

 private:
  static constexpr std::size_t kFirstIndexed = kMaxUnits / 2;

  const StoredTree& tree_;
  std::vector<std::byte>& nodes_;
  std::map<std::size_t, std::size_t> places_;  ///< of indexed leaves, which many may share: unit -> number
  std::vector<std::size_t> ranks_;             ///< of each number, in the order of units
  std::size_t first_indexed_ = 0;
};

[[noreturn]] void refuse() {
  throw BadStructureFile("has a tree that is not one");
}

void require(bool condition) {
  if (!condition) refuse();
}

class Check {
 public:
  Check(std::span<const std::byte> block, std::size_t indexed_bytes, const MeshTable& table,
        std::span<const MeshView> mesh_of_record)
      : block_(block),
        units_((block.size() - indexed_bytes) / kUnitBytes),
        indexed_bytes_(indexed_bytes),
        table_(table),
        mesh_of_record_(mesh_of_record) {}

  struct Subtree {
    std::size_t end = 0;  ///< unit behind it
    TreeCounts counts;
  };

  /// Of the subtree that begins at `begin`, if it has any units of its own; `within` is in all boxes above.
  Subtree visit(const NodeSlot& slot, std::size_t begin, std::size_t level, const Box4& within) const {
    const Box4 box = common(within, slot.bounds().whole());
    return kind_of(slot.link) == LinkKind::kLeaf ? visit_leaf(slot, begin, box)
                                                 : visit_node(slot, begin, level, box);
  }

 private:
  static Box4 common(const Box4& a, const Box4& b) { return {max(a.lower, b.lower), min(a.upper, b.upper)}; }

  Subtree visit_leaf(const NodeSlot& slot, std::size_t begin, const Box4& within) const {
    const std::size_t unit = unit_of(slot.link);
    const bool is_indexed = unit >= units_;
    require(is_indexed || (unit == begin && unit + sizeof(LeafHeader) / kUnitBytes <= units_));
    if (is_indexed) {
      const std::size_t offset = (unit - units_) * kUnitBytes;
      require(offset % kIndexedLeafBytes == 0 && offset + kIndexedLeafBytes <= indexed_bytes_);
    }
    LeafHeader leaf;
    std::memcpy(&leaf, block_.data() + unit * kUnitBytes, sizeof leaf);
    require(leaf.indexed == (is_indexed ? 1 : 0));
    require(leaf.mesh < table_.size() && table_.entry(leaf.mesh).is_used);
    require(leaf.triangle_count > 0 && leaf.triangle_count <= kWidth);
    // A change finds the leaves of a mesh by its box: all boxes above and that one have something in common.
    const Box4 all = common(within, to_box4(table_.entry(leaf.mesh).bounds));
    for (int axis = 0; axis < 3; ++axis) require(all.lower[axis] <= all.upper[axis]);
    const MeshView& mesh = mesh_of_record_[leaf.mesh];
    for (std::size_t i = 0; i < kWidth; ++i) {
      for (std::size_t corner = 0; corner < 3; ++corner) require(leaf.corners[corner][i] < kWidth);
      if (i < leaf.triangle_count) require(leaf.prim_ids[i] < mesh.triangle_count);
    }
    Subtree result;
    result.end = begin;
    result.counts.leaf_triangles = leaf.triangle_count;
    if (is_indexed) {
      require(leaf.first_segment == 0);
      check_indices(leaf, mesh);
      result.counts.indexed_leaves = 1;
      return result;
    }
    const MeshRecord& record = table_.record(leaf.mesh);
    if (!record.grid.is_static()) {
      const float first = std::max(slot.range.begin, record.grid.begin);
      require(first <= std::min(slot.range.last, record.grid.end));
      LeafHeader from_start = leaf;
      from_start.first_segment = 0;
      require(segment_of(from_start, record, first).segment == leaf.first_segment);
    } else {
      require(leaf.first_segment == 0);
    }
    const std::size_t units = inline_leaf_bytes(steps_of(leaf, record, slot.range)) / kUnitBytes;
    result.end = begin + units;
    require(result.end <= units_);
    result.counts.inline_leaves = 1;
    result.counts.leaf_units = static_cast<std::int64_t>(units);
    return result;
  }

  /// Rays follow them into the caller's buffers.
  static void check_indices(const LeafHeader& leaf, const MeshView& mesh) {
    require(mesh.indices != nullptr && mesh.steps[0].data != nullptr);
    for (std::size_t i = 0; i < leaf.triangle_count; ++i) {
      for (const std::uint32_t vertex : mesh.triangle(leaf.prim_ids[i]))
        require(vertex < mesh.steps[0].count);
    }
  }

  Subtree visit_node(const NodeSlot& slot, std::size_t begin, std::size_t level, const Box4& within) const {
    const LinkKind kind = kind_of(slot.link);
    std::size_t next = begin + node_units(kind);
    require(level < kMaxLevels && unit_of(slot.link) == begin && next <= units_);
    const std::byte* const data = block_.data() + begin * kUnitBytes;
    const NodeSlots node = read_node(kind, data, slot.range);
    require(node.count > 0);
    check_slots(kind, node, data);
    // Where each child begins follows from its link; that they stand side by side is looked at afterwards.
    std::array<Subtree, kWidth> children;
    const auto visit_child = [&](std::size_t i) {
      const NodeSlot& child = node.slots[i];
      const bool has_units = kind_of(child.link) != LinkKind::kLeaf || unit_of(child.link) < units_;
      if (has_units) require(unit_of(child.link) >= next);
      children[i] = visit(child, has_units ? unit_of(child.link) : 0, level + 1, within);
    };
    if (level < kParallelLevels) {
      tbb::parallel_for(std::size_t{0}, node.count, visit_child);
    } else {
      for (std::size_t i = 0; i < node.count; ++i) visit_child(i);
    }
    Subtree result;
    for (std::size_t i = 0; i < node.count; ++i) {
      const NodeSlot& child = node.slots[i];
      result.counts.add(children[i].counts);
      result.counts.expected_area += expected_area(child.bounds(), child.range);
      if (kind_of(child.link) == LinkKind::kLeaf && unit_of(child.link) >= units_) continue;
      require(unit_of(child.link) == next);
      next = children[i].end;
    }
    result.end = next;
    result.counts.add_node(kind, node.count);
    ++result.counts.depth;
    return result;
  }

  /// Numbers are finite, times within those of the node, and nothing stands in places without a child: what
  /// rays compute there must not make them enter.
  template <typename Node>
  static void check_slots(const NodeSlots& node, const std::byte* data) {
    for (const NodeSlot& slot : node.used()) {
      for (std::size_t plane = 0; plane < kPlanes; ++plane)
        require(std::isfinite(slot.planes[plane]) && std::isfinite(slot.slopes[plane]));
      require(slot.range.begin <= slot.range.last && slot.range.begin >= node.range.begin &&
              slot.range.last <= node.range.last);
    }
    Node raw;
    std::memcpy(&raw, data, sizeof raw);
    constexpr float inf = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < kWidth; ++i) {
      const bool is_used = i < node.count;
      for (std::size_t plane = 0; plane < kPlanes; ++plane) {
        const float none = plane < kUpperX ? inf : -inf;
        require(is_used ? raw.planes[plane][i] != none : raw.planes[plane][i] == none);
        if constexpr (requires { raw.slopes; }) require(is_used || raw.slopes[plane][i] == 0.0f);
      }
      require(is_used || raw.children[i] == 0);
      if constexpr (requires { raw.time_last; })
        require(is_used || (raw.time_begin[i] == 0.0f && raw.time_last[i] == 0.0f));
    }
    if constexpr (std::is_same_v<Node, LinearNode>) require(raw.time_begin == node.range.begin);
  }

  static void check_slots(LinkKind kind, const NodeSlots& node, const std::byte* data) {
    if (kind == LinkKind::kStaticNode) return check_slots<StaticNode>(node, data);
    if (kind == LinkKind::kLinearNode) return check_slots<LinearNode>(node, data);
    check_slots<SpatialTemporalNode>(node, data);
  }

  std::span<const std::byte> block_;
  std::size_t units_;  ///< of nodes and inline leaves
  std::size_t indexed_bytes_;
  const MeshTable& table_;
  std::span<const MeshView> mesh_of_record_;
};

}  // namespace

OrderedBlock in_order(const StoredTree& tree) {
  OrderedBlock ordered;
  if (tree.is_empty) return ordered;
  if (tree.counts.indexed_leaves > 0 && tree.space.end() > kMaxUnits / 2)
    throw std::length_error("a structure of more than 16 GiB with indexed leaves cannot be saved");
  ordered.bytes.reserve(tree.space.end() * kUnitBytes);
  Ordering ordering(tree, ordered.bytes);
  ordered.root = ordering.write(tree.root.link, tree.root.range);
  ordered.indexed_bytes = ordering.write_indexed_leaves();
  if (ordered.indexed_bytes > 0) ordering.link_indexed_leaves(ordered.root, tree.root.range);
  ordered.root = ordering.final_link(ordered.root);
  return ordered;
}

TreeCounts checked_counts(std::span<const std::byte> block, std::size_t indexed_bytes, const NodeSlot& root,
                          const MeshTable& table, std::span<const MeshView> mesh_of_record) {
  require(block.size() % kUnitBytes == 0 && block.size() / kUnitBytes <= kMaxUnits);
  require(indexed_bytes <= block.size() && indexed_bytes % kIndexedLeafBytes == 0);
  require(root.range.begin >= 0.0f && root.range.begin <= root.range.last && root.range.last <= 1.0f);
  for (std::size_t plane = 0; plane < kPlanes; ++plane)
    require(std::isfinite(root.planes[plane]) && std::isfinite(root.slopes[plane]));
  const Check check(block, indexed_bytes, table, mesh_of_record);
  constexpr float inf = std::numeric_limits<float>::infinity();
  const Check::Subtree all = check.visit(root, 0, 0, Box4{F32x4(-inf), F32x4(inf)});
  require(all.end * kUnitBytes + indexed_bytes == block.size());
  return all.counts;
}

}  // namespace stbvh
