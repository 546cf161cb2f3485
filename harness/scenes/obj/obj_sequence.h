/// Which OBJ files make an animation.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// Whether `name` means OBJ files: it ends in .obj, or is a folder.
bool is_obj_name(const std::string& name);

/// What the scene of such a name is called: the files' name without their number.
std::string obj_scene_name(const std::string& name);

/// The files of the steps: one .obj file; or those of a pattern, with one %d as in printf, or else one row of
/// # or one $F as in Houdini, for a number of any width, and %% for a %; or all .obj files of a folder, by
/// the last number in their names, which are otherwise the same. Numbers may be negative; they go up by
/// `number_step` from the least. Hidden files of a folder are left out and named to `warn`. Throws
/// SceneFileError, which names the file, for others that do not fit in, and for more than kMaxSceneSteps.
std::vector<std::filesystem::path> find_obj_files(const std::string& name, const SceneWarning& warn = {},
                                                  std::size_t number_step = 1);

}  // namespace stbvh::harness
