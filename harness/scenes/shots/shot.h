/// Meshes, camera and lights that harness/scenes/shots/read_shot.py has read of a USD or Alembic file.
#pragma once

#include <filesystem>
#include <string>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// Whether `name` means such a file, by its ending.
bool is_shot_name(const std::string& name);

/// The scene of the records in `handover`, which a sentence calls by the file's `name`. Each mesh keeps its
/// steps, at times of their own where they are not equidistant; polygons are cut into triangles by their
/// first step (cut_polygon()), cages refined as those of Embree's XML are. What the script had finished is
/// used where it ended early: then `ending` says how ("was ended by a signal"). Tells `warn` what is left
/// out. Without meshes where the file shows none then. Throws SceneFileError where it cannot be read.
Scene load_shot(const std::filesystem::path& handover, const std::string& name, const std::string& ending,
                const SceneWarning& warn);

}  // namespace stbvh::harness
