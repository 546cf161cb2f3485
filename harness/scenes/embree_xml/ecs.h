/// Files of command-line options of Embree's tools (.ecs).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "harness/scenes/embree_xml/problem.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::embree_xml {

/// What such a file says of a scene.
struct CommandList {
  std::vector<std::filesystem::path> scene_files;  ///< beside the list, if not absolute
  std::optional<Vec3f> position, target, direction, up;
  std::optional<float> vertical_fov_degrees;
  std::string camera_name;  ///< of one in the scene files; empty: the first
  std::vector<DirectionalLight> directional_lights;
  std::optional<Vec3f> ambient;
};

/// `camera` with what the list says of it.
Camera camera_of(const CommandList& list, Camera camera);

/// Options that do not concern the scene are named in a warning. Throws Problem for those that do, but have
/// too few numbers, and for files that are not there.
CommandList read_command_list(const std::filesystem::path& file, const Warn& warn);

}  // namespace stbvh::harness::embree_xml
