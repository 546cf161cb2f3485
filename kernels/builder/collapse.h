/// From the binary tree to nodes of eight children, at the least expected cost: dynamic programming over how
/// many children of the wide node each binary subtree becomes (as Ylitie, Karras, Laine, HPG 2017, section 4,
/// with the probabilities of the MBSAH).
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "builder/binary_node.h"
#include "builder/byte_price.h"

namespace stbvh {

/// [i]: least expected cost, in expected area, of nodes' memory too, of a subtree as at most i + 1 children
/// of a node above it.
using CollapseCosts = std::array<float, kWidth>;

CollapseCosts leaf_costs(const BinaryLeaf& leaf);

/// Fills `shares` of a node whose children have these costs, and returns its own.
CollapseCosts share_slots(BinaryInner& node, const CollapseCosts& left, const CollapseCosts& right,
                          const BytePrice& price);

/// The subtrees that become the children of a wide node, two to eight, in the tree's order.
template <typename Node>
struct WideChildren {
  std::array<Node*, kWidth> nodes;
  std::size_t count = 0;

  Node& operator[](std::size_t i) const { return *nodes[i]; }
  std::span<Node* const> span() const { return {nodes.data(), count}; }
};

/// Of the wide node made of `node`.
WideChildren<BinaryNode> wide_children(BinaryInner& node);
WideChildren<const BinaryNode> wide_children(const BinaryInner& node);

/// The order in which occlusion rays try the children they meet: what is large and decides soon comes first.
void sort_for_occlusion(WideChildren<const BinaryNode>& children);

}  // namespace stbvh
