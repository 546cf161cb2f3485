/// From the binary tree to nodes of eight children, at the least expected cost: dynamic programming over how
/// many children of the wide node each binary subtree becomes (as Ylitie, Karras, Laine, HPG 2017, section 4,
/// with the probabilities of the MBSAH).
#pragma once

#include "build/binary_tree.h"

namespace stbvh {

/// Fills cost and from_left of a leaf, or of a node whose children have theirs.
void update_collapse_cost(BinaryNode& node);

/// The subtrees that become the children of the wide node made of `node` (not a leaf), two to eight, in the
/// tree's order; returns how many.
std::size_t wide_children(BinaryNode& node, std::array<BinaryNode*, kWidth>& children);

}  // namespace stbvh
