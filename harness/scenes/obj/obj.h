/// Scenes of Wavefront OBJ files: one, or an animation with one for each step.
#pragma once

#include <cstddef>
#include <string>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// One mesh for each material, with a step for each file that find_obj_files() finds, and a camera that sees
/// all of it. The first file says how faces are cut into triangles (cut_polygon()) and which materials they
/// have; the others may differ from it in positions. Tells `warn` a sentence for each kind of thing that is
/// left out, or has more than one meaning. Throws SceneFileError.
Scene load_obj(const std::string& name, const SceneWarning& warn = {}, std::size_t number_step = 1);

}  // namespace stbvh::harness
