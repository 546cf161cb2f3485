/// Bytes -> an .obj file -> a scene, or the refusal.
#include "harness/scenes/obj/obj_sequence.h"
#include "reader_input.h"

namespace stbvh::fuzz {
namespace {

void run(Bytes bytes) {
  static const InputFolder folder;
  try {
    check_scene(harness::load_obj(folder.write("input.obj", bytes).string()));
  } catch (const harness::SceneFileError&) {
  }
}

}  // namespace
}  // namespace stbvh::fuzz

extern "C" __attribute__((visibility("default"))) int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                                                             std::size_t size) {
  stbvh::fuzz::use_one_thread();
  stbvh::fuzz::run({data, size});
  return 0;
}
