#include "reader_input.h"

#include <stdlib.h>
#include <tbb/global_control.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "require.h"

namespace stbvh::fuzz {
namespace {

namespace fs = std::filesystem;
using harness::Mesh;

bool is_finite(const Vec3f& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_mesh(const Mesh& mesh) {
  require(!mesh.steps.empty() && mesh.steps.size() <= kMaxSteps, "a mesh has 1 to kMaxSteps steps");
  require(!mesh.has_step_times() || mesh.step_times.size() == mesh.steps.size(), "each step has its time");
  for (std::size_t k = 1; k < mesh.step_times.size(); ++k)
    require(mesh.step_times[k] - mesh.step_times[k - 1] >= std::numeric_limits<float>::min(),
            "steps are apart");
  for (const auto& step : mesh.steps)
    require(step.size() == mesh.steps.front().size(), "all steps have the same vertices");
  require(mesh.indices.size() % 3 == 0, "triangles have three corners");
  for (const std::uint32_t index : mesh.indices)
    require(index < mesh.steps.front().size(), "triangles have vertices that are there");
  for (const auto& step : mesh.steps) {
    for (const std::uint32_t index : mesh.indices) require(is_finite(step[index]), "triangles are somewhere");
  }
  require(mesh.motion_range().begin < mesh.motion_range().end, "a mesh is there for some time");
}

}  // namespace

InputFolder::InputFolder() {
  std::string name = (fs::temp_directory_path() / "stbvh_fuzz_XXXXXX").string();
  require(mkdtemp(name.data()) != nullptr, "there is room for the input");
  path_ = name;
}

fs::path InputFolder::write(const std::string& name, Bytes bytes) const {
  std::ofstream file(path_ / name, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  require(file.flush().good(), "the input can be written");
  return path_ / name;
}

fs::path InputFolder::write(const std::string& name, const std::string& text) const {
  return write(name, Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void check_scene(const harness::Scene& scene) {
  for (const Mesh& mesh : scene.meshes) check_mesh(mesh);
  require(is_finite(scene.camera.position) && is_finite(scene.camera.target) && is_finite(scene.camera.up),
          "the camera is somewhere");
}

}  // namespace stbvh::fuzz

extern "C" __attribute__((visibility("default"))) int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                                                             std::size_t size) {
  // What an input covers must not depend on who runs the tasks.
  static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  stbvh::fuzz::run({data, size});
  return 0;
}
