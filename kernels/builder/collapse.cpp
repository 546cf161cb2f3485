#include "builder/collapse.h"

#include <limits>

#include "builder/mbsah.h"

namespace stbvh {

CollapseCosts leaf_costs(const BinaryLeaf& leaf) {
  CollapseCosts costs;
  costs.fill(expected_area(leaf.bounds(), leaf.range) * kLeafCost);
  return costs;
}

CollapseCosts share_slots(BinaryInner& node, const CollapseCosts& left, const CollapseCosts& right) {
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
  costs[0] = expected_area(node.bounds(), node.range) * kNodeCost + split_costs[kWidth - 1];
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
std::size_t append(BinaryNode* node, std::size_t slots, std::array<BinaryNode*, kWidth>& children,
                   std::size_t count) {
  if (!node->is_leaf()) {
    const BinaryInner& inner = as_inner(*node);
    while (slots > 1 && inner.shares.from_left(slots) == 0) --slots;
    if (slots > 1) {
      const std::size_t left = inner.shares.from_left(slots);
      count = append(inner.children[0], left, children, count);
      return append(inner.children[1], slots - left, children, count);
    }
  }
  children[count] = node;
  return count + 1;
}

}  // namespace

std::size_t wide_children(const BinaryInner& node, std::array<BinaryNode*, kWidth>& children) {
  const std::size_t left = node.shares.own_from_left();
  const std::size_t count = append(node.children[0], left, children, 0);
  return append(node.children[1], kWidth - left, children, count);
}

}  // namespace stbvh
