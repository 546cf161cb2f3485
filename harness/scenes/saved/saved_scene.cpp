#include "harness/scenes/saved/saved_scene.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "harness/scenes/finite_check.h"
#include "harness/scenes/scene_views.h"

namespace stbvh::harness {
namespace {

using Json = nlohmann::json;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& problem) {
  throw SceneFileError(fmt::format("\"{}\" {}.", file.string(), problem));
}

// What a scene has beside its meshes' buffers: JSON, its length before it, faces and pixels behind it
// ------------------------------------------------------

Json to_json(const Vec3f& v) {
  return {v.x, v.y, v.z};
}
Vec3f to_vector(const Json& json) {
  return {json.at(0).get<float>(), json.at(1).get<float>(), json.at(2).get<float>()};
}

Json to_json(const Camera& camera) {
  return {to_json(camera.position), to_json(camera.target), to_json(camera.up), camera.vertical_fov_degrees};
}
Camera to_camera(const Json& json) {
  return {to_vector(json.at(0)), to_vector(json.at(1)), to_vector(json.at(2)), json.at(3).get<float>()};
}

Json to_json(const Mesh& mesh) {
  const Material& m = mesh.material;
  return {mesh.name,           static_cast<int>(m.kind), to_json(m.color), m.roughness, m.index_of_refraction,
          to_json(m.emission), !mesh.faces.empty()};
}
void enter(const Json& json, Mesh& mesh) {
  mesh.name = json.at(0).get<std::string>();
  const int kind = json.at(1).get<int>();
  if (kind < 0 || kind > static_cast<int>(Material::Kind::kGlass)) throw std::out_of_range("kind");
  mesh.material = {static_cast<Material::Kind>(kind), to_vector(json.at(2)), json.at(3).get<float>(),
                   json.at(4).get<float>(), to_vector(json.at(5))};
}

/// Takes the faces of `mesh` off the front of `bytes`, where it has any.
void enter_faces(const Json& json, std::span<const std::byte>& bytes, Mesh& mesh) {
  if (!json.at(6).get<bool>()) return;
  const std::size_t size = mesh.triangle_count() * sizeof(std::uint32_t);
  if (size > bytes.size()) throw std::out_of_range("faces");
  mesh.faces.resize(mesh.triangle_count());
  if (size > 0) std::memcpy(mesh.faces.data(), bytes.data(), size);
  bytes = bytes.subspan(size);
}

std::string surroundings_of(const Scene& scene) {
  Json json;
  json["tolerance"] = scene.tolerance;
  if (scene.max_bytes) json["max_bytes"] = *scene.max_bytes;
  json["meshes"] = Json::array();
  for (const Mesh& mesh : scene.meshes) json["meshes"].push_back(to_json(mesh));
  json["camera"] = to_json(scene.camera);
  json["camera_steps"] = Json::array();
  for (const Camera& camera : scene.camera_steps) json["camera_steps"].push_back(to_json(camera));
  json["directional"] = Json::array();
  for (const DirectionalLight& light : scene.directional_lights)
    json["directional"].push_back(
        {to_json(light.direction), to_json(light.irradiance), light.half_angle_degrees});
  json["points"] = Json::array();
  for (const PointLight& light : scene.point_lights)
    json["points"].push_back({to_json(light.position), to_json(light.intensity), to_json(light.axis),
                              light.inner_angle_degrees, light.outer_angle_degrees});
  if (scene.environment) {
    const Environment& sky = *scene.environment;
    json["environment"] = {to_json(sky.radiance), sky.width, sky.height};
  }
  // Names may hold bytes that are not UTF-8: replaced, not thrown over.
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::uint64_t length = text.size();
  std::string result(reinterpret_cast<const char*>(&length), sizeof length);
  result += text;
  for (const Mesh& mesh : scene.meshes)
    result.append(reinterpret_cast<const char*>(mesh.faces.data()),
                  mesh.faces.size() * sizeof(std::uint32_t));
  if (scene.environment) {
    const std::vector<Vec3f>& pixels = scene.environment->pixels;
    result.append(reinterpret_cast<const char*>(pixels.data()), pixels.size() * sizeof(Vec3f));
  }
  return result;
}

Environment to_environment(const Json& json, std::span<const std::byte> bytes) {
  Environment sky;
  sky.radiance = to_vector(json.at(0));
  sky.width = json.at(1).get<std::size_t>();
  sky.height = json.at(2).get<std::size_t>();
  const std::size_t pixels = bytes.size() / sizeof(Vec3f);
  const bool fits = sky.height == 0 ? sky.width == 0 && pixels == 0
                                    : pixels % sky.height == 0 && pixels / sky.height == sky.width;
  if (!fits || bytes.size() % sizeof(Vec3f) != 0) throw std::out_of_range("pixels");
  sky.pixels.resize(pixels);
  if (pixels > 0) std::memcpy(sky.pixels.data(), bytes.data(), bytes.size());
  return sky;
}

/// Refuses what no scene has: deep nesting needs a deep stack.
Json parsed(std::string_view text) {
  constexpr int kMostLevels = 8;
  Json json = Json::parse(
      text,
      [](int depth, Json::parse_event_t, Json&) {
        if (depth > kMostLevels) throw std::out_of_range("depth");
        return true;
      },
      true);
  return json;
}

void enter_surroundings(std::span<const std::byte> bytes, Scene& scene) {
  std::uint64_t length = 0;
  if (bytes.size() < sizeof length) throw std::out_of_range("length");
  std::memcpy(&length, bytes.data(), sizeof length);
  bytes = bytes.subspan(sizeof length);
  if (length > bytes.size()) throw std::out_of_range("length");
  const Json json = parsed({reinterpret_cast<const char*>(bytes.data()), length});
  scene.tolerance = json.at("tolerance").get<float>();
  if (json.contains("max_bytes")) scene.max_bytes = json.at("max_bytes").get<std::size_t>();
  const Json& meshes = json.at("meshes");
  if (meshes.size() != scene.meshes.size()) throw std::out_of_range("meshes");
  bytes = bytes.subspan(length);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    enter(meshes.at(i), scene.meshes[i]);
    enter_faces(meshes.at(i), bytes, scene.meshes[i]);
  }
  scene.camera = to_camera(json.at("camera"));
  for (const Json& camera : json.at("camera_steps")) scene.camera_steps.push_back(to_camera(camera));
  for (const Json& light : json.at("directional"))
    scene.directional_lights.push_back(
        {to_vector(light.at(0)), to_vector(light.at(1)), light.at(2).get<float>()});
  for (const Json& light : json.at("points"))
    scene.point_lights.push_back({to_vector(light.at(0)), to_vector(light.at(1)), to_vector(light.at(2)),
                                  light.at(3).get<float>(), light.at(4).get<float>()});
  if (json.contains("environment")) scene.environment = to_environment(json.at("environment"), bytes);
}

// Buffers ---------------------------------------------------------------------------------------------------

/// Copies `view`, whose elements stand side by side, into `mesh`; false: a triangle has a vertex that is not
/// there.
bool copy_buffers(const MeshView& view, Mesh& mesh) {
  constexpr std::size_t kChunk = 1 << 20;
  mesh.indices.resize(3 * view.triangle_count);
  const auto copy = [&](void* to, const void* from, std::size_t bytes) {
    tbb::parallel_for(std::size_t{0}, (bytes + kChunk - 1) / kChunk, [&](std::size_t i) {
      std::memcpy(static_cast<std::byte*>(to) + i * kChunk, static_cast<const std::byte*>(from) + i * kChunk,
                  std::min(kChunk, bytes - i * kChunk));
    });
  };
  copy(mesh.indices.data(), view.indices, mesh.indices.size() * sizeof mesh.indices[0]);
  for (const VertexBufferView& step : view.steps) {
    mesh.steps.emplace_back(step.count);
    copy(mesh.steps.back().data(), step.data, step.count * sizeof(Vec3f));
  }
  return std::ranges::all_of(mesh.indices, [&](std::uint32_t index) { return index < view.steps[0].count; });
}

}  // namespace

std::string to_saved_file(const Scene& scene, const Structure& structure) {
  const SceneViews views(scene);
  const std::string surroundings = surroundings_of(scene);
  std::string file;
  save_structure(structure, views.meshes(), {.user_data = std::as_bytes(std::span(surroundings))},
                 [&](std::span<const std::byte> piece) {
                   file.append(reinterpret_cast<const char*>(piece.data()), piece.size());
                 });
  return file;
}

Scene load_saved(const std::filesystem::path& file, const SceneWarning& warn) {
  Scene scene;
  try {
    auto saved = std::make_shared<SavedStructure>(file);
    if (!saved->has_buffers() && !saved->meshes().empty()) fail(file, "holds a structure without its meshes");
    for (const MeshView& view : saved->meshes()) {
      Mesh& mesh = scene.meshes.emplace_back();
      mesh.time_range = view.time_range;
      mesh.step_times.assign(view.step_times.begin(), view.step_times.end());
      mesh.mask = view.mask;
      if (!copy_buffers(view, mesh)) fail(file, "has a triangle with a vertex that is not there");
    }
    enter_surroundings(saved->user_data(), scene);
    scene.saved = std::move(saved);
  } catch (const BadStructureFile& error) {
    fail(file, error.what());
  } catch (const std::system_error& error) {
    fail(file, fmt::format("cannot be read: {}", error.code().message()));
  } catch (const Json::exception&) {
    fail(file, "holds no scene beside its structure");
  } catch (const std::out_of_range&) {
    fail(file, "holds no scene beside its structure");
  }
  leave_out_invalid_triangles(scene, file, warn);
  return scene;
}

}  // namespace stbvh::harness
