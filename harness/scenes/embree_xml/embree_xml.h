/// Scenes in the XML format of Embree's own tools (its tutorials pathtracer and viewer): reading.
#pragma once

#include <filesystem>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// Reads an .xml file, and the .bin file that its arrays may stand in; or an .ecs file, a list of
/// command-line options of Embree's tools, of which those for scene, camera and lights count. Each mesh is
/// placed in world space once for each time that it is instanced; one that moves by itself and with
/// transforms gets steps at the keys of both. Without a camera in the file, one that sees everything. Each
/// warning comes once. Throws SceneFileError, also where nothing is left that can be shown.
Scene load_embree_xml(const std::filesystem::path& file, const SceneWarning& warn = {});

}  // namespace stbvh::harness
