/// Animated meshes from glTF 2.0 files (.glb, .gltf): skins, morph targets, node animation.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// What happens when the shutter is open before a clip begins or behind its end.
enum class ShutterMode {
  kClamp,  ///< everything keeps the first or last key's value
  kLoop,   ///< the clip is played again
};

struct GltfOptions {
  std::string clip;                          ///< name or index of the animation; empty: the first
  std::optional<TimeRange> shutter_seconds;  ///< part of the clip, or more; default: all of it
  std::size_t steps = 9;                     ///< key positions of each moving mesh, 1 to kMaxSteps
  /// If there is one, each mesh has as few steps, up to kMaxSteps, as keep all vertices this close to their
  /// true places; a share, between 0 and 1, of the diagonal of the scene's bounds over the shutter.
  std::optional<double> largest_deviation = std::nullopt;
  ShutterMode shutter_mode = ShutterMode::kClamp;
};

/// Reads a file and evaluates `steps` positions over the shutter, in world space. Primitives are concatenated
/// in depth-first order of the default scene, one Mesh each; one that does not move gets one step. Tells
/// `warn` a sentence where kMaxSteps steps are not enough for `largest_deviation`. Throws SceneFileError.
Scene load_gltf(const std::filesystem::path& file, const GltfOptions& options = {},
                const std::function<void(const std::string& sentence)>& warn = {});

}  // namespace stbvh::harness
