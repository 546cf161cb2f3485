#include "harness/scenes/gltf/gltf.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <vector>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/gltf/adaptive_steps.h"
#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/gltf/gltf_file.h"
#include "harness/scenes/gltf/pose.h"
#include "harness/scenes/gltf/primitive.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/gltf/timeline.h"

namespace stbvh::harness {
namespace gltf {
namespace {

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

struct NamedPrimitive {
  std::string name;
  Vec3f color;
  Primitive primitive;
};

std::vector<NamedPrimitive> read_primitives(const tinygltf::Model& model, const NodeTree& tree,
                                            std::size_t most_steps) {
  std::vector<NamedPrimitive> primitives;
  std::size_t bytes = 0;
  for (const std::size_t node : tree.scene_nodes()) {
    const int mesh_index = model.nodes[node].mesh;
    if (mesh_index == -1) continue;
    if (mesh_index < 0 || static_cast<std::size_t>(mesh_index) >= model.meshes.size()) {
      fail("node {} refers to the missing mesh {}", node, mesh_index);
    }
    const auto& sources = model.meshes[static_cast<std::size_t>(mesh_index)].primitives;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      check_cancelled();
      std::optional<Primitive> primitive = read_primitive(model, node, sources[i]);
      if (!primitive) continue;
      bytes += primitive->vertex_count() * sizeof(Vec3f) * most_steps;
      if (bytes > kMaxSceneFileBytes)
        fail("its vertices need more than {} GB with {} steps", kMaxSceneFileBytes >> 30, most_steps);
      primitives.push_back(
          {mesh_name(model, node, i), base_color(model, sources[i].material), std::move(*primitive)});
    }
  }
  if (primitives.empty()) fail("its scene has no triangles");
  return primitives;
}

/// All steps of a primitive, or one if it stands still.
std::vector<VertexBuffer> all_steps(const Primitive& primitive, const std::vector<Pose>& poses) {
  std::vector<VertexBuffer> steps(poses.size());
  for_all(poses.size(), [&](std::size_t i) { steps[i] = deform(primitive, poses[i]); });
  const bool still = std::all_of(steps.begin() + 1, steps.end(),
                                 [&](const VertexBuffer& step) { return same_bits(steps.front(), step); });
  if (still) steps.resize(1);
  return steps;
}

/// Poses at equidistant times of the shutter.
std::vector<Pose> equidistant_poses(const Timeline& timeline, std::size_t steps) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < (timeline.is_instant() ? 1 : steps); ++i) {
    poses.push_back(timeline.pose(steps > 1 ? static_cast<double>(i) / static_cast<double>(steps - 1) : 0.0));
  }
  return poses;
}

/// Of the bounds over the shutter, which are looked at 33 times.
double scene_diagonal(const std::vector<NamedPrimitive>& primitives, const Timeline& timeline) {
  Scene corners;  // of what was seen so far, as the steps of a mesh
  std::vector<VertexBuffer>& seen = corners.meshes.emplace_back().steps;
  for (const Pose& pose : equidistant_poses(timeline, 33)) {
    check_cancelled();
    for (const NamedPrimitive& named : primitives) seen.push_back(deform(named.primitive, pose));
    const Box3f box = corners.bounds();
    seen.assign(1, VertexBuffer(2));
    seen[0][0] = box.lower;
    seen[0][1] = box.upper;
  }
  return std::hypot(double{seen[0][1].x} - seen[0][0].x, double{seen[0][1].y} - seen[0][0].y,
                    double{seen[0][1].z} - seen[0][0].z);
}

/// As many steps for each primitive as it needs.
std::vector<std::vector<VertexBuffer>> adaptive_steps(const std::vector<NamedPrimitive>& primitives,
                                                      const Timeline& timeline, double share,
                                                      const std::function<void(const std::string&)>& warn) {
  const double diagonal = scene_diagonal(primitives, timeline);
  std::vector<std::vector<VertexBuffer>> result;
  std::size_t too_few = 0;
  double worst = 0;
  for (const NamedPrimitive& named : primitives) {
    AdaptiveSteps chosen = choose_steps(named.primitive, timeline, share * diagonal);
    too_few += chosen.deviation > share * diagonal ? 1u : 0u;
    worst = std::max(worst, chosen.deviation);
    result.push_back(std::move(chosen.steps));
  }
  if (too_few > 0) {
    warn(
        fmt::format("{} of {} meshes stay further than {:.3g} of the diagonal from their true places even "
                    "with {} steps; the furthest {:.3g}",
                    too_few, primitives.size(), share, kMaxSteps, worst / diagonal));
  }
  return result;
}

void check_options(const GltfOptions& options) {
  if (options.steps < 1 || options.steps > kMaxSteps) {
    fail("{} steps are asked for, but only 1 to {} are possible", options.steps, kMaxSteps);
  }
  if (options.largest_deviation && !(*options.largest_deviation > 0 && *options.largest_deviation < 1)) {
    fail("a deviation of {} diagonals is asked for, but it must lie between 0 and 1",
         *options.largest_deviation);
  }
}

Scene load(const std::filesystem::path& file, const GltfOptions& options,
           const std::function<void(const std::string&)>& warn) {
  check_options(options);
  const tinygltf::Model model = read_gltf_file(file);
  const std::optional<Clip> clip = read_clip(model, options.clip);
  const NodeTree tree(model);
  const Timeline timeline(model, tree, clip, options);
  std::vector<NamedPrimitive> primitives =
      read_primitives(model, tree, options.largest_deviation ? kMaxSteps : options.steps);
  std::vector<std::vector<VertexBuffer>> steps;
  if (options.largest_deviation) {
    steps = adaptive_steps(primitives, timeline, *options.largest_deviation, warn);
  } else {
    const std::vector<Pose> poses = equidistant_poses(timeline, options.steps);
    for (const NamedPrimitive& named : primitives) steps.push_back(all_steps(named.primitive, poses));
  }
  Scene scene;
  scene.name = file.stem().string();
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    Mesh& mesh = scene.meshes.emplace_back();
    mesh.name = std::move(primitives[i].name);
    mesh.material.color = primitives[i].color;
    mesh.steps = std::move(steps[i]);
    mesh.indices = std::move(primitives[i].primitive.indices);
  }
  scene.camera = framing_camera(scene);
  return scene;
}

}  // namespace
}  // namespace gltf

Scene load_gltf(const std::filesystem::path& file, const GltfOptions& options,
                const std::function<void(const std::string&)>& warn) {
  const auto warn_of_file = [&](const std::string& sentence) {
    if (warn) warn(fmt::format("{}: {}", file.string(), sentence));
  };
  try {
    return gltf::load(file, options, warn_of_file);
  } catch (const gltf::Problem& problem) {
    throw SceneFileError(fmt::format("{}: {}", file.string(), problem.what()));
  } catch (const std::bad_alloc&) {
    throw SceneFileError(fmt::format("{}: there is not enough memory for it", file.string()));
  }
}

}  // namespace stbvh::harness
