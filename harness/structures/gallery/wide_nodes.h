/// Writes a binary tree as nodes of eight children that a method has made up, with the kernels' leaves.
#pragma once

#include <tbb/parallel_for.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "block.h"
#include "builder/collapse.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "layout/meshlet.h"
#include "layout/node_slots.h"

namespace stbvh::harness::gallery {

/// `Method` has
///   Bounds                                  of a subtree
///   Bounds of_leaf(const BinaryLeaf&)       may be called by several threads at once, as all of these
///   Bounds joined(span<const Bounds*>)      of a node, from those of its children
///   size_t bytes(span<const Bounds*>)       of the node that holds these children, a multiple of kUnitBytes
///   void write(span<const Bounds*>, span<const Link>, std::byte*)
/// Links to nodes have the kind kLinearNode, whatever they are.
template <typename Method>
class WideNodes {
 public:
  WideNodes(const BuildContext& context, const Method& method, const BinaryNode& root)
      : context_(context), method_(method), root_(make(root)) {}

  std::size_t bytes() const { return root_.units * kUnitBytes; }
  /// Into bytes() of memory, aligned to kUnitBytes.
  Link write(std::byte* data) const { return write(root_, data, 0); }

 private:
  using Bounds = typename Method::Bounds;
  static constexpr std::size_t kParallelLeaves = 4096;

  struct Node {
    Bounds bounds;
    const BinaryLeaf* leaf = nullptr;
    std::vector<Node> children;
    std::size_t units = 0;  ///< of the subtree
    std::size_t leaves = 1;
  };

  struct ChildBounds {
    std::array<const Bounds*, kWidth> pointers;
    std::size_t count;

    explicit ChildBounds(const Node& node) : count(node.children.size()) {
      for (std::size_t i = 0; i < count; ++i) pointers[i] = &node.children[i].bounds;
    }
    std::span<const Bounds* const> span() const { return {pointers.data(), count}; }
  };

  template <typename Body>
  static void for_each_child(std::size_t leaves, std::size_t count, const Body& body) {
    if (leaves >= kParallelLeaves) return tbb::parallel_for(std::size_t{0}, count, body);
    for (std::size_t i = 0; i < count; ++i) body(i);
  }

  std::size_t steps_of(const BinaryLeaf& leaf) const {
    return context_.meshes[leaf.mesh].steps_in(leaf.range);
  }

  Node make(const BinaryNode& node) const {
    if (node.is_leaf()) {
      const BinaryLeaf& leaf = as_leaf(node);
      return {method_.of_leaf(leaf), &leaf, {}, inline_leaf_bytes(steps_of(leaf)) / kUnitBytes, 1};
    }
    Node wide;
    WideChildren<const BinaryNode> children = wide_children(as_inner(node));
    sort_for_occlusion(children);
    wide.leaves = node.subtree_leaves;
    wide.children.resize(children.count);
    for_each_child(wide.leaves, children.count, [&](std::size_t i) { wide.children[i] = make(children[i]); });
    const ChildBounds bounds(wide);
    wide.bounds = method_.joined(bounds.span());
    wide.units = method_.bytes(bounds.span()) / kUnitBytes;
    for (const Node& child : wide.children) wide.units += child.units;
    return wide;
  }

  Link write(const Node& node, std::byte* data, std::size_t unit) const {
    std::byte* const out = data + unit * kUnitBytes;
    if (node.leaf != nullptr) {
      const BinaryLeaf& leaf = *node.leaf;
      const std::size_t first = leaf.segments.first;
      write_inline_leaf(leaf.mesh, *leaf.meshlet, first,
                        context_.meshes[leaf.mesh].view().steps.subspan(first, steps_of(leaf)), out);
      return make_link(LinkKind::kLeaf, unit);
    }
    const ChildBounds bounds(node);
    std::array<std::size_t, kWidth> units{};
    std::size_t next = unit + method_.bytes(bounds.span()) / kUnitBytes;
    for (std::size_t i = 0; i < bounds.count; ++i) {
      units[i] = next;
      next += node.children[i].units;
    }
    std::array<Link, kWidth> links{};
    for_each_child(node.leaves, bounds.count,
                   [&](std::size_t i) { links[i] = write(node.children[i], data, units[i]); });
    method_.write(bounds.span(), std::span(links).first(bounds.count), out);
    return make_link(LinkKind::kLinearNode, unit);
  }

  const BuildContext& context_;
  const Method& method_;
  Node root_;
};

/// The whole of it: what GalleryTree::Method::write returns.
template <typename Method>
WrittenTree write_wide_nodes(const BuildContext& context, const Method& method, const BinaryNode& root,
                             const GalleryKernels& kernels, ChildrenAt children_at,
                             std::shared_ptr<const void> shared, std::size_t shared_bytes) {
  const WideNodes<Method> nodes(context, method, root);
  Block block({}, nodes.bytes());
  const Link link = nodes.write(block.data());
  return {std::move(block), link, kernels, children_at, std::move(shared), shared_bytes};
}

}  // namespace stbvh::harness::gallery
