#include "harness/program/scene_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "harness/program/closest_name.h"
#include "harness/program/program.h"
#include "harness/program/shot_reader.h"
#include "harness/program/usage_error.h"
#include "harness/scenes/embree_xml/embree_xml.h"
#include "harness/scenes/obj/obj.h"
#include "harness/scenes/obj/obj_sequence.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/resampled.h"
#include "harness/scenes/saved/saved_scene.h"
#include "harness/scenes/shots/shot.h"
#include "harness/scenes/vec3.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

/// In lower case, with its dot; empty where there is none.
std::string extension_of(const std::string& name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_embree_file(const std::string& name) {
  return extension_of(name) == ".xml" || extension_of(name) == ".ecs";
}

bool is_gltf_file(const std::string& name) {
  return extension_of(name) == ".glb" || extension_of(name) == ".gltf";
}

bool is_file_name(const std::string& name) {
  return is_gltf_file(name) || extension_of(name) == ".stbvh" || is_embree_file(name);
}

/// Before anything is printed or measured. What else is wrong with it, its reader says.
void check_reachable(const std::string& name) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(name, error);
  if (status.type() == std::filesystem::file_type::not_found)
    throw UsageError(fmt::format("There is no file \"{}\".", name));
  if (error) throw UsageError(fmt::format("Cannot read \"{}\": {}.", name, error.message()));
}

/// As checked(), of that part of a file's time.
Scene checked_part(Scene scene, const std::string& name, const std::optional<FilePart>& part) {
  const bool is_empty = scene.meshes.empty() && may_be_empty(part);
  if (!is_empty) return checked(std::move(scene), name);
  scene.name = name;
  return scene;
}

SceneSource file_source(const std::string& name, const MakingOptions& making) {
  check_reachable(name);
  const std::string stem = std::filesystem::path(name).stem().string();
  if (extension_of(name) == ".stbvh")
    return {stem, [=, warn = making.warn] { return checked(load_saved(name, warn), stem); }};
  if (is_embree_file(name))
    return {stem, [=, warn = making.warn] { return checked(load_embree_xml(name, warn), stem); }};
  return {stem, [=, gltf = making.gltf, warn = making.warn] {
            return checked_part(load_gltf(name, gltf, warn), stem, gltf.shutter);
          }};
}

SceneSource obj_source(const std::string& name, const MakingOptions& making) {
  const std::string scene_name = obj_scene_name(name);
  for (const auto& file : find_obj_files(name, {}, making.obj_step)) check_reachable(file.string());
  return {scene_name, [=, step = making.obj_step, warn = making.warn] {
            return checked(load_obj(name, warn, step), scene_name);
          }};
}

SceneSource shot_source(const std::string& name, const MakingOptions& making) {
  check_reachable(name);
  const std::string stem = std::filesystem::path(name).stem().string();
  ShotOptions shot{.shutter = making.gltf.shutter};
  if (making.gltf.at_keys && making.gltf.largest_deviation)
    shot.largest_deviation = *making.gltf.largest_deviation;
  return {stem,
          [=, warn = making.warn] { return checked_part(read_shot(name, shot, warn), stem, shot.shutter); }};
}

SceneSource built_in_source(const std::string& name, const MakingOptions& options) {
  const ProceduralScene* scene = find_procedural_scene(name);
  if (scene == nullptr) {
    std::vector<std::string_view> known;
    for (const ProceduralScene& s : procedural_scenes()) known.push_back(s.name);
    throw UsageError(unknown_name("scene", name, known));
  }
  const double scale = options.scale.value_or(scene->default_scale);
  return {name, [=, seed = options.seed] { return checked(scene->make(scale, seed), name); }};
}

/// Seconds are counted from a clip's beginning.
void check_shutter(const std::string& name, const FilePart& shutter) {
  if (!shutter.is_in_frames && (shutter.begin < 0 || shutter.begin >= shutter.end))
    throw UsageError(
        fmt::format("--shutter must be A,B with 0 <= A < B, not \"{},{}\".", shutter.begin, shutter.end));
  const bool has_clock = is_shot_name(name) || is_gltf_file(name);
  if (shutter.is_in_frames && !has_clock)
    throw UsageError(
        fmt::format("--frames: \"{}\" has no frames: glTF, USD and Alembic files have them.", name));
}

SceneSource find_source(const std::string& name, const MakingOptions& making) {
  if (making.gltf.shutter) check_shutter(name, *making.gltf.shutter);
  if (find_procedural_scene(name) == nullptr && is_obj_name(name)) return obj_source(name, making);
  if (is_shot_name(name)) return shot_source(name, making);
  return is_file_name(name) ? file_source(name, making) : built_in_source(name, making);
}

/// As Scene::max_bytes.
std::optional<std::size_t> bytes_of(const MemoryBudget& budget, const Scene& scene) {
  if (!budget.share) return budget.bytes;
  if (scene.meshes.empty()) return {};
  if (const std::string why = obstacle("embree", scene); !why.empty())
    throw UsageError(fmt::format("--max-bytes: embree, of whose bytes it is a share, has none: {}.", why));
  const std::size_t embrees = build_structure("embree", scene, 0)->build_record().structure_bytes;
  return static_cast<std::size_t>(*budget.share * static_cast<double>(embrees));
}

}  // namespace

Scene checked(Scene scene, const std::string& name) {
  scene.name = name;
  if (scene.triangle_count() == 0) throw UsageError(fmt::format("The scene \"{}\" has no triangles.", name));
  const Box3f box = scene.bounds();
  const double size = length(to_double(box.upper) - to_double(box.lower));
  if (!std::isfinite(size)) {
    throw UsageError(fmt::format("The scene \"{}\" has positions that are not finite.", name));
  }
  if (!(size > 0)) throw UsageError(fmt::format("The scene \"{}\" has no extent.", name));
  return scene;
}

Scene handed_over(Scene scene, const Resampling& resampling, double tolerance, const MemoryBudget& budget) {
  if (resampling.steps > 0) scene = resampled(std::move(scene), resampling.steps, resampling.places);
  if (scene.saved != nullptr && tolerance == 0 && !budget.bytes && !budget.share)
    return scene;  // as it was built
  scene.saved = nullptr;
  scene.tolerance = static_cast<float>(tolerance * diagonal(scene.bounds()));
  scene.max_bytes = bytes_of(budget, scene);
  return scene;
}

SceneSource find_scene(const std::string& name, const MakingOptions& making) {
  SceneSource source = find_source(name, making);
  source.load = [load = std::move(source.load), resampling = making.resampling, tolerance = making.tolerance,
                 budget = making.max_bytes] { return handed_over(load(), resampling, tolerance, budget); };
  return source;
}

std::vector<SceneSource> find_scenes(const SceneOptions& options) {
  std::vector<SceneSource> sources;
  for (const std::string& name : options.scenes) sources.push_back(find_scene(name, options));
  return sources;
}

SceneSummary summarize(const Scene& scene) {
  return {.name = scene.name,
          .meshes = scene.meshes.size(),
          .triangles = scene.triangle_count(),
          .primitive_segments = scene.primitive_segment_count(),
          .buffer_bytes = scene.buffer_bytes()};
}

}  // namespace stbvh::harness
