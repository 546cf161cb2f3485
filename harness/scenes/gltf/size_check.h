/// How much memory a glTF file asks for, before any of it is given.
#pragma once

#include <cstddef>
#include <vector>

#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/model.h"
#include "harness/scenes/gltf/node_tree.h"
#include "harness/scenes/gltf/visibility.h"

namespace stbvh::harness::gltf {

/// Most bytes that a file may ask for: kMaxExpansion times its own, or kFreeBytes more.
double most_bytes_of(const Model& model);

/// Throws Problem where keys, geometry, instances and `steps` positions of all that moves, together, need
/// more than most_bytes_of(model), or an accessor among them reaches beyond its data. `nodes` are those of
/// the scene. Each is counted once or, where it is known, for each time that it is to be seen.
void check_sizes(const Model& model, const NodeTree& tree, const std::vector<std::size_t>& nodes,
                 const ClipSource* clip, std::size_t steps, const Visibility* visibility = nullptr);

}  // namespace stbvh::harness::gltf
