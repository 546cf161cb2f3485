#include "harness/scenes/gltf/left_out.h"

#include <fmt/format.h>

#include <set>
#include <string>

#include "harness/scenes/gltf/extensions.h"
#include "harness/scenes/gltf/primitive.h"
#include "harness/scenes/name_list.h"

namespace stbvh::harness::gltf {
namespace {

constexpr std::size_t kMostNamed = 10;

std::string plural(std::size_t count, const std::string& one, const std::string& many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

void warn_of_extensions(const Model& model, const SceneWarning& warn) {
  NameList unread(kMostNamed);
  for (const std::string& name : unread_extensions(model.extensions)) unread.add(name);
  if (unread.count() > 0) warn(fmt::format("left out: what these extensions say: {}", unread.text()));
}

void warn_of_animation(const ClipSource* clip, const SceneWarning& warn) {
  if (clip == nullptr || clip->left_out.empty()) return;
  NameList kinds(kMostNamed);
  for (const auto& [kind, count] : clip->left_out)
    kinds.add(fmt::format("{} of {}", count, kind.empty() ? "nothing" : kind.substr(0, 80)));
  warn(fmt::format("left out: channels of the animation that move what is not read: {}", kinds.text()));
}

/// The primitives that nodes of the scene show, each once.
std::vector<const Model::Primitive*> shown_primitives(const Model& model,
                                                      const std::vector<std::size_t>& nodes) {
  std::set<std::size_t> meshes;
  for (const std::size_t node : nodes) {
    if (model.nodes[node].mesh) meshes.insert(*model.nodes[node].mesh);
  }
  std::vector<const Model::Primitive*> primitives;
  for (const std::size_t mesh : meshes) {
    for (const Model::Primitive& primitive : model.meshes[mesh].primitives) primitives.push_back(&primitive);
  }
  return primitives;
}

void warn_of_primitives(const std::vector<const Model::Primitive*>& primitives, const SceneWarning& warn) {
  std::size_t points_or_lines = 0, without_positions = 0, colored = 0;
  for (const Model::Primitive* primitive : primitives) {
    if (primitive->mode < kTriangles) {
      ++points_or_lines;
    } else if (!has_triangles(*primitive)) {
      ++without_positions;
    } else if (primitive->attributes.contains("COLOR_0")) {
      ++colored;
    }
  }
  if (points_or_lines > 0)
    warn(fmt::format("left out: {} of points or lines", plural(points_or_lines, "primitive", "primitives")));
  if (without_positions > 0)
    warn(fmt::format("left out: {} without positions", plural(without_positions, "primitive", "primitives")));
  if (colored > 0)
    warn(fmt::format("left out: the vertex colors of {}", plural(colored, "primitive", "primitives")));
}

void warn_of_materials(const Model& model, const std::vector<const Model::Primitive*>& primitives,
                       const SceneWarning& warn) {
  std::set<std::size_t> used;
  for (const Model::Primitive* primitive : primitives) {
    if (primitive->material && *primitive->material < model.materials.size())
      used.insert(*primitive->material);
  }
  std::size_t textured = 0, glowing = 0, transparent = 0, not_diffuse = 0;
  for (const std::size_t i : used) {
    const Model::Material& material = model.materials[i];
    const Vec3f& light = material.emission;
    const bool emits = light.x > 0 || light.y > 0 || light.z > 0;
    textured += material.has_textures;
    glowing += material.has_emissive_texture && emits;
    transparent += !material.is_opaque;
    not_diffuse += !material.is_diffuse;
  }
  const auto tell = [&](std::size_t count, const char* what) {
    if (count > 0) warn(fmt::format("left out: {} of {}", what, plural(count, "material", "materials")));
  };
  tell(textured, "the textures");
  tell(glowing, "the light, which a texture says where to emit,");
  tell(transparent, "the transparency");
  tell(not_diffuse, "metal and roughness");
}

}  // namespace

void warn_of_what_is_left_out(const Model& model, const std::vector<std::size_t>& nodes,
                              const ClipSource* clip, const SceneWarning& warn) {
  warn_of_extensions(model, warn);
  warn_of_animation(clip, warn);
  const std::vector<const Model::Primitive*> primitives = shown_primitives(model, nodes);
  warn_of_primitives(primitives, warn);
  warn_of_materials(model, primitives, warn);
}

}  // namespace stbvh::harness::gltf
