#include "builder/encoder.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <stdexcept>

#include "builder/collapse.h"
#include "builder/mbsah.h"
#include "layout/meshlet.h"
#include "layout/node_plan.h"
#include "layout/node_slots.h"

namespace stbvh {

namespace {

/// Subtrees of fewer leaves are walked by one thread.
constexpr std::size_t kParallelLeaves = 4096;
constexpr std::uint32_t kNone = 0xFFFFFFFFu;

NodePlan plan_node(const BinaryNode& node, std::span<const BinaryNode* const> children) {
  NodePlan plan;
  plan.range = node.range;
  for (const BinaryNode* child : children) plan.children[plan.count++] = {child->bounds(), child->range, 0};
  return plan;
}

/// An indexed leaf by what each byte would bring that made it inline; of equal ones the first in the tree
/// comes first.
struct RankedLeaf {
  float worth;
  std::uint32_t index;

  bool operator<(const RankedLeaf& other) const {
    return worth != other.worth ? worth > other.worth : index < other.index;
  }
};

void collect_leaves(BinaryNode& node, std::vector<BinaryLeaf*>& leaves) {
  if (node.is_leaf()) {
    leaves.push_back(&as_leaf(node));
    return;
  }
  for (std::size_t i = 0; i < 2; ++i) collect_leaves(as_inner(node).child(i), leaves);
}

template <typename Body>
void for_each_child(bool parallel, std::size_t count, const Body& body) {
  if (parallel) {
    tbb::parallel_for(std::size_t{0}, count, body);
  } else {
    for (std::size_t i = 0; i < count; ++i) body(i);
  }
}

}  // namespace

Encoder::Encoder(BuildContext& context, BinaryNode* root, std::size_t most_bytes)
    : context_(context), root_(root) {
  if (root == nullptr) return;
  counts_ = measure(*root);
  units_ = root_->units;
  if (bytes() > most_bytes) {
    std::size_t node_bytes = 0;
    for (const LinkKind kind : {LinkKind::kStaticNode, LinkKind::kLinearNode, LinkKind::kSpatialTemporalNode})
      node_bytes += static_cast<std::size_t>(counts_.nodes[static_cast<std::size_t>(kind)]) *
                    node_units(kind) * kUnitBytes;
    choose_leaves(*root, most_bytes - std::min(node_bytes, most_bytes));
    counts_ = measure(*root);
    units_ = root_->units;
  }
  if (bytes() > kMaxUnits * kUnitBytes) throw std::length_error("structure larger than 32 GiB");
}

void Encoder::choose_leaves(BinaryNode& root, std::size_t most_bytes) {
  std::size_t meshlets = 0;
  for (const MeshletSet& set : context_.meshlets) {
    first_meshlet_.push_back(meshlets);
    meshlets += set.meshlets().size();
  }
  constexpr std::size_t kLeafBytes = sizeof(BinaryLeaf*) + sizeof(RankedLeaf);
  const CountedMemory counted(context_.memory,
                              root.subtree_leaves * kLeafBytes + meshlets * 2 * sizeof(std::uint32_t));
  std::vector<BinaryLeaf*> leaves;
  leaves.reserve(root.subtree_leaves);
  collect_leaves(root, leaves);
  // All leaves of a meshlet that are indexed are one.
  std::vector<std::uint32_t> indexed_leaves(meshlets);
  std::size_t bytes = 0;
  for (BinaryLeaf* const leaf : leaves) {
    leaf->is_indexed = true;
    if (indexed_leaves[meshlet_number(*leaf)]++ == 0) bytes += kIndexedLeafBytes;
  }
  std::vector<RankedLeaf> ranked(leaves.size());
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    const float shared =
        float{kIndexedLeafBytes} / static_cast<float>(indexed_leaves[meshlet_number(*leaves[i])]);
    const float size = static_cast<float>(inline_leaf_bytes(leaf_steps(*leaves[i]))) - shared;
    ranked[i] = {expected_area(leaves[i]->bounds(), leaves[i]->range) / size, i};
  }
  tbb::parallel_sort(ranked.begin(), ranked.end());
  for (const RankedLeaf& rank : ranked) {
    BinaryLeaf* const leaf = leaves[rank.index];
    std::uint32_t& others = indexed_leaves[meshlet_number(*leaf)];
    const std::size_t inline_bytes =
        bytes + inline_leaf_bytes(leaf_steps(*leaf)) - (others == 1 ? kIndexedLeafBytes : 0);
    if (inline_bytes > most_bytes) continue;
    leaf->is_indexed = false;
    --others;
    bytes = inline_bytes;
  }
  indexed_.assign(meshlets, kNone);
  for (std::size_t i = 0; i < meshlets; ++i) {
    if (indexed_leaves[i] > 0) indexed_[i] = static_cast<std::uint32_t>(indexed_count_++);
  }
}

std::size_t Encoder::leaf_steps(const BinaryLeaf& leaf) const {
  return context_.meshes[leaf.mesh].is_static() ? 1 : leaf.segments.last - leaf.segments.first + 2;
}

std::size_t Encoder::meshlet_number(const BinaryLeaf& leaf) const {
  return first_meshlet_[leaf.mesh] +
         static_cast<std::size_t>(leaf.meshlet - context_.meshlets[leaf.mesh].meshlets().data());
}

std::size_t Encoder::leaf_units(const BinaryLeaf& leaf) const {
  return leaf.is_indexed ? 0 : inline_leaf_bytes(leaf_steps(leaf)) / kUnitBytes;
}

TreeCounts Encoder::measure(BinaryNode& node) const {
  TreeCounts counts;
  if (node.is_leaf()) {
    const BinaryLeaf& leaf = as_leaf(node);
    (leaf.is_indexed ? counts.indexed_leaves : counts.inline_leaves) = 1;
    counts.leaf_triangles = leaf.meshlet->triangle_count;
    node.units = static_cast<std::uint32_t>(leaf_units(leaf));
    counts.leaf_units = node.units;
    return counts;
  }
  const WideChildren<BinaryNode> children = wide_children(as_inner(node));
  std::array<TreeCounts, kWidth> child_counts;
  const bool parallel = node.subtree_leaves >= kParallelLeaves;
  for_each_child(parallel, children.count, [&](std::size_t i) { child_counts[i] = measure(children[i]); });
  const LinkKind kind = plan_node(node, children.span()).kind();
  std::size_t units = node_units(kind);
  for (std::size_t i = 0; i < children.count; ++i) {
    counts.add(child_counts[i]);
    counts.expected_area += stbvh::expected_area(children[i].bounds(), children[i].range);
    units += children[i].units;
  }
  node.units = static_cast<std::uint32_t>(std::min(units, kMaxUnits + 1));  // more is refused in the end
  counts.add_node(kind, children.count);
  ++counts.depth;
  return counts;
}

Link Encoder::encode(std::byte* data, std::size_t first_unit, std::span<const std::uint32_t> records) const {
  const Target target{data, first_unit + units_, records};
  for (std::size_t mesh = 0; mesh < first_meshlet_.size(); ++mesh) {
    const std::span<const Meshlet> meshlets = context_.meshlets[mesh].meshlets();
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, meshlets.size(), kParallelLeaves), [&](const auto& part) {
          for (std::size_t i = part.begin(); i != part.end(); ++i) {
            const std::uint32_t number = indexed_[first_meshlet_[mesh] + i];
            if (number == kNone) continue;
            write_indexed_leaf(records[mesh], meshlets[i],
                               data + target.first_indexed * kUnitBytes + number * kIndexedLeafBytes);
          }
        });
  }
  return encode_node(*root_, target, first_unit);
}

Link Encoder::encode_node(const BinaryNode& node, const Target& target, std::size_t unit) const {
  if (node.is_leaf()) {
    const BinaryLeaf& leaf = as_leaf(node);
    if (leaf.is_indexed) {
      const std::size_t number = indexed_[meshlet_number(leaf)];
      return make_link(LinkKind::kLeaf, target.first_indexed + number * (kIndexedLeafBytes / kUnitBytes));
    }
    const std::size_t first = leaf.segments.first;
    const auto steps = context_.meshes[leaf.mesh].view().steps.subspan(first, leaf_steps(leaf));
    write_inline_leaf(target.records[leaf.mesh], *leaf.meshlet, first, steps,
                      target.data + unit * kUnitBytes);
    return make_link(LinkKind::kLeaf, unit);
  }
  WideChildren<const BinaryNode> children = wide_children(as_inner(node));
  sort_for_occlusion(children);
  NodePlan plan = plan_node(node, children.span());
  const LinkKind kind = plan.kind();
  std::array<std::size_t, kWidth> units;
  std::size_t next = unit + node_units(kind);
  for (std::size_t i = 0; i < children.count; ++i) {
    units[i] = next;
    next += children[i].units;
  }
  for_each_child(node.subtree_leaves >= kParallelLeaves, children.count,
                 [&](std::size_t i) { plan.children[i].link = encode_node(children[i], target, units[i]); });
  write_node(plan, target.data + unit * kUnitBytes);
  return make_link(kind, unit);
}

}  // namespace stbvh
