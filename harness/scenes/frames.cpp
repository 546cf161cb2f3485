#include "harness/scenes/frames.h"

#include <fmt/format.h>

#include <algorithm>

namespace stbvh::harness {
namespace {

/// Everything of a scene but its meshes.
Scene surroundings(const Scene& scene) {
  Scene result;
  result.name = scene.name;
  result.camera = scene.camera;
  result.camera_steps = scene.camera_steps;
  result.directional_lights = scene.directional_lights;
  result.point_lights = scene.point_lights;
  result.environment = scene.environment;
  result.tolerance = scene.tolerance;
  return result;
}

/// Everything of a mesh but its steps.
Mesh without_steps(const Mesh& mesh) {
  Mesh result;
  result.name = mesh.name;
  result.indices = mesh.indices;
  result.time_range = mesh.time_range;
  result.mask = mesh.mask;
  result.material = mesh.material;
  return result;
}

void check(const Mesh& mesh, std::size_t frames) {
  if (mesh.is_static()) return;
  if (mesh.has_step_times() || mesh.time_range.begin != 0.0f || mesh.time_range.end != 1.0f)
    throw SceneFileError(
        fmt::format("\"{}\" does not move with equidistant steps over the whole shutter.", mesh.name));
  if (frames * mesh.segment_count() + 1 > kMaxSteps)
    throw SceneFileError(fmt::format("\"{}\" would have {} steps in {} frames, and {} is the most.",
                                     mesh.name, frames * mesh.segment_count() + 1, frames, kMaxSteps));
}

}  // namespace

Scene played(const Scene& shutter, std::size_t frames) {
  Scene animation = surroundings(shutter);
  for (const Mesh& mesh : shutter.meshes) {
    check(mesh, frames);
    Mesh& played = animation.meshes.emplace_back(without_steps(mesh));
    const std::size_t segments = mesh.segment_count();
    if (segments == 0) {
      played.steps = mesh.steps;
      continue;
    }
    for (std::size_t step = 0; step <= frames * segments; ++step) {
      const std::size_t frame = step / segments, of_frame = step % segments;
      played.steps.push_back(mesh.steps[frame % 2 == 0 ? of_frame : segments - of_frame]);
    }
  }
  return animation;
}

Scene frame_of(const Scene& animation, std::size_t frame, std::size_t frames) {
  Scene scene = surroundings(animation);
  for (const Mesh& mesh : animation.meshes) {
    Mesh& part = scene.meshes.emplace_back(without_steps(mesh));
    const std::size_t segments = mesh.segment_count() / frames;
    const auto first = mesh.steps.begin() + static_cast<std::ptrdiff_t>(frame * segments);
    part.steps.assign(first, first + static_cast<std::ptrdiff_t>(segments + 1));
  }
  return scene;
}

Scene in_pieces(const Scene& scene) {
  constexpr std::size_t kMostSegments = kMaxSceneSteps - 1;
  Scene result = surroundings(scene);
  for (const Mesh& mesh : scene.meshes) {
    const std::size_t segments = mesh.segment_count();
    if (segments <= kMostSegments) {
      result.meshes.push_back(mesh);
      continue;
    }
    for (std::size_t first = 0; first < segments; first += kMostSegments) {
      const std::size_t last = std::min(first + kMostSegments, segments);
      Mesh& piece = result.meshes.emplace_back(without_steps(mesh));
      piece.steps.assign(mesh.steps.begin() + static_cast<std::ptrdiff_t>(first),
                         mesh.steps.begin() + static_cast<std::ptrdiff_t>(last + 1));
      piece.time_range = {static_cast<float>(mesh.step_time(first)),
                          static_cast<float>(mesh.step_time(last))};
    }
  }
  return result;
}

}  // namespace stbvh::harness
