/// From an Embree XML file to its scene graph.
#pragma once

#include <filesystem>

#include "harness/scenes/embree_xml/node.h"
#include "harness/scenes/embree_xml/problem.h"

namespace stbvh::harness::embree_xml {

/// All of the file's nodes, below one. Tells `warn` what is left out. Throws SceneFileError, with the file's
/// name and the line where there is one.
NodePtr read_file(const std::filesystem::path& file, const Warn& warn);

}  // namespace stbvh::harness::embree_xml
