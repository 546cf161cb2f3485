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
#include "harness/scenes/finite_check.h"
#include "harness/scenes/gltf/framing.h"
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

/// A moving mesh must be seen for this part of [0, 1], and its range be no longer than that: Debian's Embree
/// aborts the process while it builds over others.
constexpr float kLeastTimeSeen = 0x1p-10f, kLongestTimeRange = 16;

bool is_seen(const Mesh& mesh) {
  const TimeRange& range = mesh.time_range;
  const float seen = std::min(range.end, 1.0f) - std::max(range.begin, 0.0f);
  return mesh.is_static() || (seen >= kLeastTimeSeen && range.end - range.begin <= kLongestTimeRange);
}

void leave_out_unseen_meshes(Scene& scene, const Warn& warn) {
  std::string names;
  for (const Mesh& mesh : scene.meshes) {
    if (!is_seen(mesh)) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", mesh.name);
  }
  if (names.empty()) return;
  std::erase_if(scene.meshes, [](const Mesh& mesh) { return !is_seen(mesh); });
  warn(fmt::format(
      "Meshes whose time range holds less than {} of [0, 1], or is longer than {}, are left out: {}.",
      kLeastTimeSeen, kLongestTimeRange, names));
}

Scene make_scene(FlatScene flat, const CommandList& list, const std::filesystem::path& file,
                 const Warn& warn) {
  Scene scene;
  scene.meshes = std::move(flat.meshes);
  leave_out_invalid_triangles(scene, file, warn);
  leave_out_unseen_meshes(scene, warn);
  if (scene.meshes.empty())
    throw Problem("nothing in it can be shown: there are no triangles, quads or cages");
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
