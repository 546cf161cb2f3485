/// Animated meshes from glTF 2.0 files (.glb, .gltf): skins, morph targets, node animation.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

struct GltfOptions {
  std::string clip;                          ///< name or index of the animation; empty: the first
  std::optional<TimeRange> shutter_seconds;  ///< part of the clip; default: all of it
  std::size_t steps = 9;                     ///< key positions of each moving mesh, 1 to kMaxSteps
};

/// Reads a file and evaluates `steps` positions over the shutter, in world space. Primitives are concatenated
/// in depth-first order of the default scene, one Mesh each; one that does not move gets one step. Throws
/// SceneFileError.
Scene load_gltf(const std::filesystem::path& file, const GltfOptions& options = {});

}  // namespace stbvh::harness
