/// Wavefront OBJ: the positions and polygons of one file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "harness/scenes/scene_file.h"
#include "stbvh/vec.h"

namespace stbvh::harness {

struct ObjFile {
  std::vector<Vec3f> positions;           ///< maybe not finite
  std::vector<std::uint32_t> face_sizes;  ///< corners of each face, at least 3
  std::vector<std::uint32_t> corners;     ///< of all faces, one after another; indices of positions

  /// The faces from one on have a material, until the next run.
  struct MaterialRun {
    std::size_t first_face;
    std::string name;
  };
  std::vector<MaterialRun> material_runs;
  std::vector<std::string> material_libraries;  ///< what stands behind each `mtllib`
  std::string left_out;                         ///< how many shapes are no faces, by keyword
};

/// Reads `v`, `f` (once `fo`), `usemtl` and `mtllib` of a file, all objects and groups together; counts other
/// shapes and ignores everything else. A number may count from the vertices so far backwards, a line go on
/// after a backslash. Throws SceneFileError, with the line.
///
/// Not by tinyobjloader, the reader that Debian has: it takes numbers that it cannot read for 0 without a
/// word, and knows no continued lines.
ObjFile read_obj_file(const std::filesystem::path& file);

}  // namespace stbvh::harness
