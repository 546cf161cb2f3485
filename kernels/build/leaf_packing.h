/// Packing references into a leaf: up to eight triangles of one mesh over up to eight vertices.
#pragma once

#include <optional>

#include "build/binary_tree.h"
#include "build/build_context.h"
#include "build/reference_set.h"

namespace stbvh {

/// The leaf that holds the whole set, if one can. Vertices that differ in index but not in position, at any
/// step of the leaf, count once.
std::optional<BinaryLeaf> pack_leaf(const BuildContext& context, const ReferenceSet& set);

/// Linear bounds of a leaf over `range`, tighter than those of its references together.
LinearBounds leaf_bounds(const BuildContext& context, const BinaryLeaf& leaf, const ClosedTimeRange& range);

}  // namespace stbvh
