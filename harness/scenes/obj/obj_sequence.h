/// Animations as Wavefront OBJ files, one for each step.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// Whether `name` means OBJ files: it ends in .obj, or is a folder.
bool is_obj_name(const std::string& name);

/// What the scene of such a name is called: the files' name without their number.
std::string obj_scene_name(const std::string& name);

/// The files of the steps: one .obj file; "walk_%04d.obj", with one %d as in printf; or all .obj files of a
/// folder, by the last number in their names, which are otherwise the same. Numbers go up by one from the
/// least. Throws SceneFileError, also for more than kMaxSteps.
std::vector<std::filesystem::path> find_obj_files(const std::string& name);

/// One mesh with a step for each file, and a camera that sees it all. Throws SceneFileError, also where the
/// files differ in more than positions.
Scene load_obj(const std::string& name);

}  // namespace stbvh::harness
