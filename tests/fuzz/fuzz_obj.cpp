/// Bytes -> an .obj file -> a scene, or the refusal.
#include "harness/scenes/obj/obj.h"
#include "reader_input.h"

namespace stbvh::fuzz {

void run(Bytes bytes) {
  static const InputFolder folder;
  try {
    check_scene(harness::load_obj(folder.write("input.obj", bytes).string()));
  } catch (const harness::SceneFileError&) {
  }
}

}  // namespace stbvh::fuzz
