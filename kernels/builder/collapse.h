/// From the binary tree to nodes of eight children, at the least expected cost: dynamic programming over how
/// many children of the wide node each binary subtree becomes (as Ylitie, Karras, Laine, HPG 2017, section 4,
/// with the probabilities of the MBSAH).
#pragma once

#include "builder/binary_tree.h"

namespace stbvh {

/// [i]: least expected cost of a subtree as at most i + 1 children of a node above it.
using CollapseCosts = std::array<float, kWidth>;

CollapseCosts leaf_costs(const BinaryLeaf& leaf);

/// Fills `shares` of a node whose children have these costs, and returns its own.
CollapseCosts share_slots(BinaryInner& node, const CollapseCosts& left, const CollapseCosts& right);

/// The subtrees that become the children of the wide node made of `node`, two to eight, in the tree's order;
/// returns how many.
std::size_t wide_children(const BinaryInner& node, std::array<BinaryNode*, kWidth>& children);

}  // namespace stbvh
