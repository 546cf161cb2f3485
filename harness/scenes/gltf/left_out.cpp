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
  if (clip == nullptr) return;
  if (clip->others > 0)
    warn(fmt::format("left out, as the first is taken: {} (--clip)",
                     plural(clip->others, "more animation", "more animations")));
  if (clip->left_out.empty()) return;
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

/// Skins place vertices in the world, wherever their nodes are.
void warn_of_skinned_instances(const Model& model, const std::vector<std::size_t>& nodes,
                               const SceneWarning& warn) {
  const auto count = std::count_if(nodes.begin(), nodes.end(), [&](std::size_t index) {
    const Model::Node& node = model.nodes[index];
    return node.mesh && node.skin && node.instances &&
           std::ranges::any_of(model.meshes[*node.mesh].primitives, has_influences);
  });
  if (count > 0)
    warn(fmt::format("left out, as what is skinned is shown once: the instances of {}",
                     plural(static_cast<std::size_t>(count), "node", "nodes")));
}

/// Whether vertices are left that make no whole triangle.
bool has_rest(const Model& model, const Model::Primitive& primitive) {
  const std::size_t accessor = primitive.indices.value_or(primitive.attributes.at("POSITION"));
  if (accessor >= model.accessors.size()) return false;
  const std::size_t count = model.accessors[accessor].count;
  return primitive.mode == kTriangles ? count % 3 != 0 : count < 3;
}

/// Whether each of the joints has its weights, and the other way round.
bool has_half_of_influences(const Model::Primitive& primitive) {
  return std::ranges::any_of(primitive.attributes, [&](const auto& attribute) {
    const std::string& name = attribute.first;
    const std::string set = name.substr(name.find('_') + 1);
    return (name.starts_with("JOINTS_") && !primitive.attributes.contains("WEIGHTS_" + set)) ||
           (name.starts_with("WEIGHTS_") && !primitive.attributes.contains("JOINTS_" + set));
  });
}

void warn_of_primitives(const Model& model, const std::vector<const Model::Primitive*>& primitives,
                        const SceneWarning& warn) {
  std::size_t points_or_lines = 0, compressed = 0, without_positions = 0, colored = 0, with_rest = 0,
              half_skinned = 0;
  for (const Model::Primitive* primitive : primitives) {
    if (primitive->mode < kTriangles) {
      ++points_or_lines;
    } else if (primitive->is_compressed) {
      ++compressed;
    } else if (!has_triangles(*primitive)) {
      ++without_positions;
    } else {
      colored += primitive->attributes.contains("COLOR_0");
      with_rest += has_rest(model, *primitive);
      half_skinned += has_half_of_influences(*primitive);
    }
  }
  const auto tell = [&](std::size_t count, fmt::format_string<std::string> sentence) {
    if (count > 0) warn(fmt::format(sentence, plural(count, "primitive", "primitives")));
  };
  tell(points_or_lines, "left out: {} of points or lines");
  tell(compressed, "left out: {} with Draco mesh compression (KHR_draco_mesh_compression) alone");
  tell(without_positions, "left out: {} without positions");
  tell(colored, "left out: the vertex colors of {}");
  tell(with_rest, "left out: the last vertices, which make no whole triangle, of {}");
  tell(half_skinned, "left out: joints without weights, or weights without joints, of {}");
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
  warn_of_skinned_instances(model, nodes, warn);
  warn_of_primitives(model, primitives, warn);
  warn_of_materials(model, primitives, warn);
}

}  // namespace stbvh::harness::gltf
