/// Bytes -> a .glb or .gltf file -> a scene, or the refusal.
#include "harness/scenes/gltf/gltf.h"
#include "reader_input.h"

namespace stbvh::fuzz {
namespace {

using harness::GltfOptions;

void read(const std::filesystem::path& file, const GltfOptions& options) {
  try {
    check_scene(harness::load_gltf(file, options));
  } catch (const harness::SceneFileError&) {
  }
}

}  // namespace

void run(Bytes bytes) {
  static const InputFolder folder;
  const bool is_binary = bytes.size() >= 4 && std::equal(bytes.begin(), bytes.begin() + 4, "glTF");
  const std::filesystem::path file = folder.write(is_binary ? "input.glb" : "input.gltf", bytes);
  GltfOptions options;
  options.steps = 3;
  read(file, options);
  options.shutter = {-1, 2};
  options.shutter_mode = harness::ShutterMode::kLoop;
  options.largest_deviation = 1e-2;
  read(file, options);
  options.at_keys = true;
  read(file, options);
}

}  // namespace stbvh::fuzz
