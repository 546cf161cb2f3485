#include "build/collapse.h"

#include <limits>

#include "build/mbsah.h"

namespace stbvh {

void update_collapse_cost(BinaryNode& node) {
  const float area = expected_area(node.bounds, node.range);
  node.from_left.fill(0);
  if (node.is_leaf()) {
    node.cost.fill(area * kLeafCost);
    return;
  }
  std::array<float, kWidth> split_cost;
  std::array<std::uint8_t, kWidth> split_left;
  for (std::size_t i = 1; i < kWidth; ++i) {
    split_cost[i] = std::numeric_limits<float>::infinity();
    for (std::size_t left = 1; left <= i; ++left) {
      const float cost = node.children[0]->cost[left - 1] + node.children[1]->cost[i - left];
      if (cost < split_cost[i] || left == 1) {
        split_cost[i] = cost;
        split_left[i] = static_cast<std::uint8_t>(left);
      }
    }
  }
  // As a node of its own it has up to eight children.
  node.cost[0] = area * kNodeCost + split_cost[kWidth - 1];
  for (std::size_t i = 1; i < kWidth; ++i) {
    const bool split = split_cost[i] < node.cost[i - 1];
    node.cost[i] = split ? split_cost[i] : node.cost[i - 1];
    node.from_left[i] = split ? split_left[i] : std::uint8_t{0};
  }
  node.own_from_left = split_left[kWidth - 1];
}

namespace {

/// Appends the subtrees that `node` becomes as at most `slots` children.
std::size_t append(BinaryNode& node, std::size_t slots, std::array<BinaryNode*, kWidth>& children,
                   std::size_t count) {
  while (slots > 1 && node.from_left[slots - 1] == 0) --slots;
  if (slots == 1) {
    children[count] = &node;
    return count + 1;
  }
  const std::size_t left = node.from_left[slots - 1];
  count = append(*node.children[0], left, children, count);
  return append(*node.children[1], slots - left, children, count);
}

}  // namespace

std::size_t wide_children(BinaryNode& node, std::array<BinaryNode*, kWidth>& children) {
  const std::size_t count = append(*node.children[0], node.own_from_left, children, 0);
  return append(*node.children[1], kWidth - node.own_from_left, children, count);
}

}  // namespace stbvh
