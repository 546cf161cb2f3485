/// From the bytes of a structure back to nodes, for NodeVisitor.
#pragma once

#include "layout/layout.h"
#include "stbvh/node_visitor.h"

namespace stbvh {

/// Shows all nodes and leaves of `structure` to `visitor`.
void walk_nodes(const StructureView& structure, NodeVisitor& visitor);

}  // namespace stbvh
