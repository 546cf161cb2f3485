/// Bytes -> an .xml file and, behind the first byte that is 0, the .bin file beside it -> a scene, or the
/// refusal; what can be read is written, and read again.
#include <algorithm>
#include <optional>

#include "harness/scenes/embree_xml/embree_xml.h"
#include "harness/scenes/embree_xml/writer.h"
#include "reader_input.h"
#include "require.h"

namespace stbvh::fuzz {
namespace {

using harness::Scene;

std::string whole(const std::vector<std::string_view>& parts) {
  std::string bytes;
  for (const std::string_view part : parts) bytes += part;
  return bytes;
}

/// What we write ourselves we do not refuse: that would end the program.
void check_written(const InputFolder& folder, const Scene& scene) {
  const harness::EmbreeXml written = harness::to_embree_xml(scene);
  const std::filesystem::path file = folder.write("again.xml", written.xml);
  folder.write("again.bin", whole(written.binary));
  const Scene again = harness::load_embree_xml(file);
  require(again.triangle_count() == scene.triangle_count(), "what is written is read again");
}

}  // namespace

void run(Bytes bytes) {
  static const InputFolder folder;
  const auto xml = static_cast<std::size_t>(std::find(bytes.begin(), bytes.end(), 0) - bytes.begin());
  const std::filesystem::path file = folder.write("input.xml", bytes.first(xml));
  folder.write("input.bin", bytes.subspan(std::min(xml + 1, bytes.size())));
  std::optional<Scene> scene;
  try {
    scene = harness::load_embree_xml(file);
  } catch (const harness::SceneFileError&) {
    return;
  }
  check_scene(*scene);
  check_written(folder, *scene);
}

}  // namespace stbvh::fuzz
