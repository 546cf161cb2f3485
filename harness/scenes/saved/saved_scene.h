/// Scenes with the structure that was built over them, in one file (.stbvh).
#pragma once

#include <filesystem>
#include <string>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"
#include "stbvh/saved_structure.h"

namespace stbvh::harness {

/// The file: `structure` was built over `scene`.
std::string to_saved_file(const Scene& scene, const Structure& structure);

/// Scene::saved is the structure, as long as meshes, tolerance and bytes stay as they are. Throws
/// SceneFileError.
Scene load_saved(const std::filesystem::path& file, const SceneWarning& warn);

}  // namespace stbvh::harness
