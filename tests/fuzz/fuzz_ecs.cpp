/// Bytes -> an .ecs file, beside scene.xml and scene.obj that it may name -> a scene, or the refusal; what
/// can be read is written, and read again.
#include <optional>

#include "harness/scenes/embree_xml/embree_xml.h"
#include "reader_input.h"
#include "written_again.h"

namespace stbvh::fuzz {
namespace {

/// With both files that an .ecs file may name.
InputFolder make_folder() {
  const InputFolder folder;
  folder.write("scene.xml",
               R"(<scene><PerspectiveCamera name="c" from="0 0 5" to="0 0 0" up="0 1 0" fov="40"/>
<TriangleMesh><positions>0 0 0  1 0 0  0 1 0</positions><triangles>0 1 2</triangles></TriangleMesh></scene>)");
  folder.write("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  return folder;
}

}  // namespace

void run(Bytes bytes) {
  static const InputFolder folder = make_folder();
  std::optional<harness::Scene> scene;
  try {
    scene = harness::load_embree_xml(folder.write("input.ecs", bytes));
  } catch (const harness::SceneFileError&) {
    return;
  }
  check_scene(*scene);
  check_written(*scene);
}

}  // namespace stbvh::fuzz
