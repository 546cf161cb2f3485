/// Cameras and lights of glTF files.
#pragma once

#include <cstddef>
#include <vector>

#include "harness/scenes/gltf/model.h"
#include "harness/scenes/gltf/timeline.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::gltf {

/// Adds the first perspective camera of `nodes`, in `steps` places over the shutter if it moves, and all
/// lights, as they are when the shutter opens. Without a camera, one that sees all meshes of `scene`. Tells
/// `warn` what is left out. Throws Problem for indices that are out of range.
void add_surroundings(const Model& model, const Timeline& timeline, const std::vector<std::size_t>& nodes,
                      std::size_t steps, const SceneWarning& warn, Scene& scene);

}  // namespace stbvh::harness::gltf
