#include "harness/scenes/embree_xml/embree_xml.h"

#include <fmt/core.h>

#include <algorithm>
#include <new>
#include <set>

#include "harness/files/input_file.h"
#include "harness/scenes/embree_xml/ecs.h"
#include "harness/scenes/embree_xml/node.h"
#include "harness/scenes/embree_xml/problem.h"
#include "harness/scenes/embree_xml/reader.h"
#include "harness/scenes/embree_xml/time_seen.h"
#include "harness/scenes/finite_check.h"
#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/light_check.h"
#include "harness/scenes/obj/obj.h"

namespace stbvh::harness {
namespace embree_xml {
namespace {

/// The camera of that name, or the first of all where it is empty.
std::optional<Camera> chosen_camera(const FlatScene& flat, const std::string& name) {
  const auto found = std::find_if(flat.cameras.begin(), flat.cameras.end(),
                                  [&](const NamedCamera& c) { return name.empty() || c.name == name; });
  if (found != flat.cameras.end()) return found->camera;
  if (!name.empty()) throw Problem(fmt::format("there is no camera named \"{}\"", name));
  return std::nullopt;
}

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

void leave_out_unseen_meshes(Scene& scene, const Warn& warn) {
  const std::string sentence = unseen_meshes(scene);
  if (sentence.empty()) return;
  std::erase_if(scene.meshes, [](const Mesh& mesh) { return !is_seen(mesh); });
  warn(sentence);
}

/// Each is right by itself; transforms and sums may have made it another.
void check_lights(const Scene& scene) {
  for (std::size_t i = 0; i < scene.directional_lights.size(); ++i) {
    if (const std::string flaw = flaw_of(scene.directional_lights[i]); !flaw.empty())
      throw Problem(fmt::format("its directional light {} {}", i + 1, flaw));
  }
  if (!scene.environment) return;
  if (const std::string flaw = flaw_of(scene.environment->radiance); !flaw.empty())
    throw Problem(fmt::format("its ambient light {}", flaw));
}

Scene make_scene(FlatScene flat, const CommandList& list, const std::filesystem::path& file,
                 const Warn& warn) {
  Scene scene;
  scene.meshes = std::move(flat.meshes);
  const std::size_t mesh_count = scene.meshes.size();
  for (Mesh& mesh : scene.meshes) {
    if (mesh.is_static()) mesh.time_range = {};  // it is always there
  }
  leave_out_invalid_triangles(scene, file, warn);
  leave_out_unseen_meshes(scene, warn);
  if (scene.meshes.empty()) {
    throw Problem(fmt::format(
        "nothing in it can be shown: {}",
        mesh_count == 0 ? "there are no triangles, quads or cages to be seen"
                        : fmt::format("all triangles of its meshes, {}, are left out", mesh_count)));
  }
  scene.directional_lights = std::move(flat.directional_lights);
  scene.directional_lights.insert(scene.directional_lights.end(), list.directional_lights.begin(),
                                  list.directional_lights.end());
  std::optional<Vec3f> ambient = flat.ambient;
  if (list.ambient) {
    const Vec3f& a = *list.ambient;
    const Vec3f sum = ambient.value_or(Vec3f{0, 0, 0});
    ambient = Vec3f{sum.x + a.x, sum.y + a.y, sum.z + a.z};
  }
  if (ambient) scene.environment.emplace().radiance = *ambient;
  check_lights(scene);
  const std::optional<Camera> camera = chosen_camera(flat, list.camera_name);
  const Camera base = camera ? *camera : gltf::framing_camera(scene);
  scene.camera = camera_of(list, base);
  const bool is_theirs = camera || problem_of(base).empty();  // not one that a scene is too large for
  if (const std::string_view problem = problem_of(scene.camera); is_theirs && !problem.empty())
    throw Problem(fmt::format("its camera {}", problem));
  return scene;
}

void add_file(Node& root, const std::filesystem::path& file, const Warn& warn) {
  const std::string extension = lower_extension(file);
  if (extension == ".xml") {
    add_child(root, read_file(file, warn));
  } else if (extension == ".obj") {
    for (Mesh& mesh : load_obj(file.string(), warn).meshes) add_child(root, make_leaf(std::move(mesh)));
  } else {
    throw Problem(
        fmt::format("\"{}\" is neither an .xml nor an .obj file; no others are supported", file.string()));
  }
}

Scene load(const std::filesystem::path& file, const Warn& warn) {
  CommandList list;
  if (lower_extension(file) == ".ecs") {
    list = read_command_list(file, warn);
  } else {
    list.scene_files = {file};
  }
  Node root;
  for (const std::filesystem::path& scene_file : list.scene_files) add_file(root, scene_file, warn);
  Scene scene = make_scene(flatten(root), list, file, warn);
  scene.name = file.stem().string();
  return scene;
}

}  // namespace
}  // namespace embree_xml

Scene load_embree_xml(const std::filesystem::path& file, const SceneWarning& warn) {
  std::set<std::string> told;
  const auto once = [&](const std::string& sentence) {
    if (told.insert(sentence).second && warn) warn(sentence);
  };
  try {
    return embree_xml::load(file, once);
  } catch (const embree_xml::Problem& problem) {
    throw SceneFileError(fmt::format("{}: {}", file.string(), problem.what()));
  } catch (const InputFileError& problem) {
    throw SceneFileError(fmt::format("{}: it {}", file.string(), problem.what()));
  } catch (const std::bad_alloc&) {
    throw SceneFileError(fmt::format("{}: there is not enough memory for it", file.string()));
  }
}

}  // namespace stbvh::harness
