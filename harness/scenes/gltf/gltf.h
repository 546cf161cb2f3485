/// Animated meshes from glTF 2.0 files (.glb, .gltf): skins, morph targets, node animation.
#pragma once

#include <cstddef>
#include <filesystem>
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
  std::string clip;                 ///< name or index of the animation; empty: the first
  std::optional<FilePart> shutter;  ///< part of the clip, or more; default: all of it
  std::size_t steps = 9;            ///< key positions of each moving mesh, 1 to kMaxSceneSteps
  /// If there is one, each mesh has as few steps, up to kMaxSceneSteps, as keep all vertices this close to
  /// their true places; a share, between 0 and 1, of the diagonal of the scene's bounds over the shutter.
  std::optional<double> largest_deviation = std::nullopt;
  ShutterMode shutter_mode = ShutterMode::kClamp;
  std::string scene{};  ///< name or index; empty: the default one, or the first that has a mesh
  /// Each mesh has its steps at the keys that it follows and at the shutter's ends, kMaxSteps at most, with
  /// more of them where its motion between two keys is curved: so that vertices are within
  /// `largest_deviation`, or kKeyDeviation, of their true places.
  bool at_keys = false;
};

/// Far below what a picture shows: 1/50 of a pixel where the scene fills 2,000.
inline constexpr double kKeyDeviation = 1e-5;

/// Reads a file and evaluates `steps` positions over the shutter, in world space. Primitives are concatenated
/// in depth-first order of the scene, one Mesh for each of their instances; one that does not move gets one
/// step. One that the animation shows and hides is a Mesh, with a time range of its own, for each time that
/// it is to be seen. The camera is the file's first, or one that sees everything. Tells `warn` a sentence for
/// each kind of thing that is left out, and where the most steps are not enough for `largest_deviation`.
/// Throws SceneFileError.
Scene load_gltf(const std::filesystem::path& file, const GltfOptions& options = {},
                const SceneWarning& warn = {});

}  // namespace stbvh::harness
