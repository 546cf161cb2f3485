#include "harness/scenes/gltf/extensions.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

constexpr std::array<std::string_view, 6> kRead = {
    "EXT_mesh_gpu_instancing",         "KHR_animation_pointer", "KHR_lights_punctual",
    "KHR_materials_emissive_strength", "KHR_mesh_quantization", "KHR_node_visibility"};

bool is_read(std::string_view name) {
  return std::find(kRead.begin(), kRead.end(), name) != kRead.end();
}

/// Extensions that change only how surfaces look and how they are lit, by what follows the vendor's name.
bool concerns_only_looks(std::string_view name) {
  constexpr std::array<std::string_view, 6> kSubjects = {"texture_", "materials_", "image_",
                                                         "lights_",  "packing_",   "xmp"};
  const std::size_t vendor = name.find('_');
  if (vendor == std::string_view::npos) return false;
  name.remove_prefix(vendor + 1);
  return std::any_of(kSubjects.begin(), kSubjects.end(),
                     [&](std::string_view subject) { return name.starts_with(subject); });
}

}  // namespace

void check_required_extensions(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (is_read(name) || concerns_only_looks(name)) continue;
    if (name == "KHR_draco_mesh_compression")
      fail("it requires Draco mesh compression ({}), which is not supported", name);
    if (name == "EXT_meshopt_compression" || name == "KHR_meshopt_compression")
      fail("it requires meshopt compression ({}), which is not supported", name);
    fail("it requires the extension {}, which is not supported", name);
  }
}

std::vector<std::string> unread_extensions(const std::vector<std::string>& names) {
  std::vector<std::string> unread = names;
  std::erase_if(unread, [](const std::string& name) { return is_read(name); });
  std::sort(unread.begin(), unread.end());
  unread.erase(std::unique(unread.begin(), unread.end()), unread.end());
  return unread;
}

}  // namespace stbvh::harness::gltf
