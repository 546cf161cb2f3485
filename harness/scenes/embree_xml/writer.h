/// Scenes in the XML format of Embree's own tools: writing.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "harness/scenes/embree_xml/embree_xml.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// A scene as such a file and, where its positions and triangles need much room, the binary file they stand
/// in.
struct EmbreeXml {
  std::string xml;
  std::vector<std::string_view> binary;  ///< parts, one behind the other; they point into the scene
};

/// The name that Embree's loader looks for the binary file of `xml_file` by.
std::filesystem::path embree_binary_file(const std::filesystem::path& xml_file);

/// What Embree's pathtracer and viewer show much as we do; read back, its meshes are bit for bit those of
/// `scene`, which have equidistant steps, kMaxSceneSteps at most. A scene without any light gets a sun and a
/// sky. What the format has no word for is told to `warn`: a picture as environment becomes its mean;
/// emission is written, but only load_embree_xml() heeds it. Masks are not written. So is what
/// load_embree_xml() would refuse or leave out: lights, cameras and meshes that nothing can be done with.
/// Throws SceneFileError where no mesh is left.
EmbreeXml to_embree_xml(const Scene& scene, const SceneWarning& warn = {});

}  // namespace stbvh::harness
