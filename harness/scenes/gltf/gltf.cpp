#include "harness/scenes/gltf/gltf.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <vector>

#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/gltf/gltf_file.h"
#include "harness/scenes/gltf/pose.h"
#include "harness/scenes/gltf/primitive.h"
#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness {
namespace gltf {
namespace {

/// Equidistant times of the steps, in seconds.
std::vector<double> step_times(const std::optional<Clip>& clip, const GltfOptions& options) {
  double begin = clip ? clip->begin : 0, end = clip ? clip->end : 0;
  if (options.shutter_seconds) {
    begin = static_cast<double>(options.shutter_seconds->begin);
    end = static_cast<double>(options.shutter_seconds->end);
    if (!std::isfinite(begin) || !std::isfinite(end) || (options.steps > 1 && begin >= end)) {
      fail("the shutter must open before it closes, but {} to {} seconds is asked for", begin, end);
    }
  }
  if (options.steps == 1 || begin >= end) return {begin};
  std::vector<double> times;
  const auto segments = static_cast<double>(options.steps - 1);
  for (std::size_t i = 0; i < options.steps; ++i) {
    times.push_back(begin + (end - begin) * (static_cast<double>(i) / segments));
  }
  return times;
}

bool same_bits(const VertexBuffer& a, const VertexBuffer& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3f)) == 0;
}

Vec3f base_color(const tinygltf::Model& model, int material) {
  if (material < 0 || static_cast<std::size_t>(material) >= model.materials.size()) return Material{}.color;
  const std::vector<double>& factor =
      model.materials[static_cast<std::size_t>(material)].pbrMetallicRoughness.baseColorFactor;
  if (factor.size() < 3) return Material{}.color;
  const auto channel = [&](std::size_t i) { return static_cast<float>(std::clamp(factor[i], 0.0, 1.0)); };
  return {channel(0), channel(1), channel(2)};
}

std::string mesh_name(const tinygltf::Model& model, std::size_t node, std::size_t primitive) {
  const tinygltf::Node& source = model.nodes[node];
  const tinygltf::Mesh& mesh = model.meshes[static_cast<std::size_t>(source.mesh)];
  std::string name = !source.name.empty() ? source.name : mesh.name;
  if (name.empty()) name = fmt::format("node {}", node);
  return mesh.primitives.size() == 1 ? name : fmt::format("{} #{}", name, primitive);
}

/// All steps of a primitive, or one if it stands still.
std::vector<VertexBuffer> all_steps(const Primitive& primitive, const std::vector<Pose>& poses) {
  std::vector<VertexBuffer> steps(poses.size());
  tbb::parallel_for(std::size_t{0}, poses.size(),
                    [&](std::size_t i) { steps[i] = deform(primitive, poses[i]); });
  const bool still = std::all_of(steps.begin() + 1, steps.end(),
                                 [&](const VertexBuffer& step) { return same_bits(steps.front(), step); });
  if (still) steps.resize(1);
  return steps;
}

std::vector<Mesh> make_meshes(const tinygltf::Model& model, const NodeTree& tree,
                              const std::vector<Pose>& poses) {
  std::vector<Mesh> meshes;
  std::size_t bytes = 0;
  for (const std::size_t node : tree.scene_nodes()) {
    const int mesh_index = model.nodes[node].mesh;
    if (mesh_index == -1) continue;
    if (mesh_index < 0 || static_cast<std::size_t>(mesh_index) >= model.meshes.size()) {
      fail("node {} refers to the missing mesh {}", node, mesh_index);
    }
    const auto& sources = model.meshes[static_cast<std::size_t>(mesh_index)].primitives;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      std::optional<Primitive> primitive = read_primitive(model, node, sources[i]);
      if (!primitive) continue;
      bytes += primitive->vertex_count() * sizeof(Vec3f) * poses.size();
      if (bytes > kMaxSceneFileBytes)
        fail("its vertices need more than {} GB with {} steps", kMaxSceneFileBytes >> 30, poses.size());
      Mesh& mesh = meshes.emplace_back();
      mesh.name = mesh_name(model, node, i);
      mesh.material.color = base_color(model, sources[i].material);
      mesh.steps = all_steps(*primitive, poses);
      mesh.indices = std::move(primitive->indices);
    }
  }
  if (meshes.empty()) fail("its scene has no triangles");
  return meshes;
}

Scene load(const std::filesystem::path& file, const GltfOptions& options) {
  if (options.steps < 1 || options.steps > kMaxSteps) {
    fail("{} steps are asked for, but only 1 to {} are possible", options.steps, kMaxSteps);
  }
  const tinygltf::Model model = read_gltf_file(file);
  const std::optional<Clip> clip = read_clip(model, options.clip);
  const NodeTree tree(model);
  std::vector<Pose> poses;
  for (const double time : step_times(clip, options)) {
    poses.push_back(pose_at(model, tree, clip ? &*clip : nullptr, time));
  }
  Scene scene;
  scene.name = file.stem().string();
  scene.meshes = make_meshes(model, tree, poses);
  scene.camera = framing_camera(scene);
  return scene;
}

}  // namespace
}  // namespace gltf

Scene load_gltf(const std::filesystem::path& file, const GltfOptions& options) {
  try {
    return gltf::load(file, options);
  } catch (const gltf::Problem& problem) {
    throw SceneFileError(fmt::format("{}: {}", file.string(), problem.what()));
  } catch (const std::bad_alloc&) {
    throw SceneFileError(fmt::format("{}: there is not enough memory for it", file.string()));
  }
}

}  // namespace stbvh::harness
