/// What of a glTF file is not read.
#pragma once

#include <cstddef>
#include <vector>

#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/model.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::gltf {

/// Tells `warn` one sentence for each kind of thing that a scene of `nodes` is shown without.
void warn_of_what_is_left_out(const Model& model, const std::vector<std::size_t>& nodes,
                              const ClipSource* clip, const SceneWarning& warn);

}  // namespace stbvh::harness::gltf
