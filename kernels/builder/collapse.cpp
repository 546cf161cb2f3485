#include "builder/collapse.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/mbsah.h"

namespace stbvh {

CollapseCosts leaf_costs(const BinaryLeaf& leaf) {
  CollapseCosts costs;
  costs.fill(expected_area(leaf.bounds(), leaf.range) * kLeafCost);
  return costs;
}

CollapseCosts share_slots(BinaryInner& node, const CollapseCosts& left, const CollapseCosts& right,
                          const BytePrice& price) {
  CollapseCosts split_costs;
  std::array<std::size_t, kWidth> split_left{};
  for (std::size_t i = 1; i < kWidth; ++i) {
    split_costs[i] = std::numeric_limits<float>::infinity();
    for (std::size_t slots = 1; slots <= i; ++slots) {
      const float cost = left[slots - 1] + right[i - slots];
      if (cost < split_costs[i] || slots == 1) {
        split_costs[i] = cost;
        split_left[i] = slots;
      }
    }
  }
  // As a node of its own it has up to eight children.
  CollapseCosts costs;
  const std::size_t bytes = node.bounds().is_static() ? sizeof(StaticNode) : sizeof(LinearNode);
  costs[0] =
      expected_area(node.bounds(), node.range) * kNodeCost + price.of_bytes(bytes) + split_costs[kWidth - 1];
  node.shares = {};
  for (std::size_t i = 1; i < kWidth; ++i) {
    const bool split = split_costs[i] < costs[i - 1];
    costs[i] = split ? split_costs[i] : costs[i - 1];
    if (split) node.shares.set_from_left(i + 1, split_left[i]);
  }
  node.shares.set_own_from_left(split_left[kWidth - 1]);
  return costs;
}

namespace {

/// Appends the subtrees that `node` becomes as at most `slots` children.
template <typename Node>
void append(Node& node, std::size_t slots, WideChildren<Node>& children) {
  if (!node.is_leaf()) {
    auto& inner = as_inner(node);
    while (slots > 1 && inner.shares.from_left(slots) == 0) --slots;
    if (slots > 1) {
      const std::size_t left = inner.shares.from_left(slots);
      append(inner.child(0), left, children);
      return append(inner.child(1), slots - left, children);
    }
  }
  children.nodes[children.count++] = &node;
}

template <typename Node, typename Inner>
WideChildren<Node> children_of(Inner& node) {
  WideChildren<Node> children;
  const std::size_t left = node.shares.own_from_left();
  append<Node>(node.child(0), left, children);
  append<Node>(node.child(1), kWidth - left, children);
  return children;
}

}  // namespace

WideChildren<BinaryNode> wide_children(BinaryInner& node) {
  return children_of<BinaryNode>(node);
}
WideChildren<const BinaryNode> wide_children(const BinaryInner& node) {
  return children_of<const BinaryNode>(node);
}

void sort_for_occlusion(WideChildren<const BinaryNode>& children) {
  const auto promise = [](const BinaryNode* node) {
    return node->bounds().centre_area() / (1.0f + std::log2(static_cast<float>(node->subtree_leaves)));
  };
  std::stable_sort(children.nodes.begin(),
                   children.nodes.begin() + static_cast<std::ptrdiff_t>(children.count),
                   [&](const BinaryNode* a, const BinaryNode* b) { return promise(a) > promise(b); });
}

}  // namespace stbvh
