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

/// Extensions of looks, of what can be touched, and of what things mean, whose names do not say so.
constexpr std::array<std::string_view, 9> kBesideGeometry = {
    "KHR_techniques_webgl",    "MOZ_lightmap",      "KHR_node_hoverability",
    "KHR_node_selectability",  "EXT_mesh_features", "EXT_instance_features",
    "EXT_structural_metadata", "FB_ngon_encoding",  "CESIUM_primitive_outline"};

template <std::size_t N>
bool is_among(const std::array<std::string_view, N>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_read(std::string_view name) {
  return is_among(kRead, name);
}

bool is_meshopt(std::string_view name) {
  return is_among(kMeshopt, name);
}

/// Extensions that change only how surfaces look and how they are lit, by what follows the vendor's name; and
/// those that change nothing of geometry and motion.
bool concerns_only_looks(std::string_view name) {
  if (is_among(kBesideGeometry, name)) return true;
  constexpr std::array<std::string_view, 6> kSubjects = {"texture_", "materials_", "image_",
                                                         "lights_",  "packing_",   "xmp"};
  const std::size_t vendor = name.find('_');
  if (vendor == std::string_view::npos) return false;
  name.remove_prefix(vendor + 1);
  return std::any_of(kSubjects.begin(), kSubjects.end(),
                     [&](std::string_view subject) { return name.starts_with(subject); });
}

}  // namespace

bool is_looked_into(std::string_view name) {
  return is_read(name) || is_meshopt(name);
}

void check_required_extensions(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (is_read(name) || concerns_only_looks(name)) continue;
    if (name == "KHR_draco_mesh_compression")
      fail("it requires Draco mesh compression ({}), which is not supported", name);
    if (is_meshopt(name)) fail("it requires meshopt compression ({}), which is not supported", name);
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
