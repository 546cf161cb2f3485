/// Wavefront OBJ: the positions and polygons of one file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "harness/scenes/scene_file.h"
#include "stbvh/vec.h"

namespace stbvh::harness {

struct ObjFile {
  std::vector<Vec3f> positions;
  std::vector<std::uint32_t> indices;  ///< 3 for each triangle; a polygon is a fan about its first corner
};

/// Reads `v` and `f` of a file, all objects and groups together; ignores everything else. A number may count
/// from the vertices so far backwards, a line go on after a backslash. Throws SceneFileError, with the line.
///
/// Not by tinyobjloader, the reader that Debian has: it takes numbers that it cannot read for 0 without a
/// word, and knows no continued lines.
ObjFile read_obj_file(const std::filesystem::path& file);

}  // namespace stbvh::harness
