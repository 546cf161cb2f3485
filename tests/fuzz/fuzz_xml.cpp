/// Bytes -> an .xml file and, behind the first byte that is 0, the .bin file beside it -> a scene, or the
/// refusal; what can be read is written, and read again.
#include <algorithm>
#include <optional>

#include "harness/scenes/embree_xml/embree_xml.h"
#include "harness/scenes/scene_file.h"
#include "reader_input.h"
#include "written_again.h"

namespace stbvh::fuzz {

void run(Bytes bytes) {
  static const InputFolder folder;
  const auto xml = static_cast<std::size_t>(std::find(bytes.begin(), bytes.end(), 0) - bytes.begin());
  const std::filesystem::path file = folder.write("input.xml", bytes.first(xml));
  folder.write("input.bin", bytes.subspan(std::min(xml + 1, bytes.size())));
  std::optional<harness::Scene> scene;
  try {
    scene = harness::load_embree_xml(file);
  } catch (const harness::SceneFileError&) {
    return;
  }
  check_scene(*scene);
  check_written(*scene);
}

}  // namespace stbvh::fuzz
