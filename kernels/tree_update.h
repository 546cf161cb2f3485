/// Structure::update: the tree changed where its meshes have changed.
#pragma once

#include <optional>
#include <span>

#include "stbvh/structure.h"
#include "stored_tree.h"

namespace stbvh {

/// None where a tree should be built anew, and the stored one is of no use any more; so it is after
/// exceptions. `peak_bytes` becomes what structure and temporary memory took together at their largest.
std::optional<UpdateStatistics> update_tree(StoredTree& tree, std::span<const MeshView> meshes,
                                            std::span<const MeshUpdate> updates,
                                            const BuildCallbacks& callbacks, std::size_t& peak_bytes);

}  // namespace stbvh
