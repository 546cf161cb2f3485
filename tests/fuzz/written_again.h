/// What we write ourselves we do not refuse.
#pragma once

#include <string>

#include "harness/scenes/embree_xml/embree_xml.h"
#include "harness/scenes/embree_xml/writer.h"
#include "reader_input.h"
#include "require.h"

namespace stbvh::fuzz {

/// Writes a scene of Embree's files, and reads it again; a refusal, which nothing catches, ends the program.
inline void check_written(const harness::Scene& scene) {
  static const InputFolder folder;
  const harness::EmbreeXml written = harness::to_embree_xml(scene);
  std::string binary;
  for (const std::string_view part : written.binary) binary += part;
  const std::filesystem::path file = folder.write("again.xml", written.xml);
  folder.write("again.bin", binary);
  require(harness::load_embree_xml(file).triangle_count() == scene.triangle_count(),
          "what is written is read again");
}

}  // namespace stbvh::fuzz
