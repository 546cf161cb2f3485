#include "harness/scenes/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace stbvh::harness {
namespace {

void check(const Mesh& mesh, std::size_t frames) {
  if (mesh.is_static()) return;
  if (mesh.has_step_times() || mesh.time_range.begin != 0.0f || mesh.time_range.end != 1.0f)
    throw SceneFileError(
        fmt::format("\"{}\" does not move with equidistant steps over the whole shutter.", mesh.name));
  if (frames * mesh.segment_count() + 1 > kMaxSteps)
    throw SceneFileError(fmt::format("\"{}\" would have {} steps in {} frames, and {} is the most.",
                                     mesh.name, frames * mesh.segment_count() + 1, frames, kMaxSteps));
}

/// Its meshes are about to be others.
Scene without_structure(Scene scene) {
  scene.saved = nullptr;
  return scene;
}

}  // namespace

Scene played(const Scene& shutter, std::size_t frames) {
  Scene animation = without_structure(shutter);
  for (std::size_t i = 0; i < shutter.meshes.size(); ++i) {
    const Mesh& mesh = shutter.meshes[i];
    check(mesh, frames);
    const std::size_t segments = mesh.segment_count();
    std::vector<VertexBuffer>& steps = animation.meshes[i].steps;
    for (std::size_t step = steps.size(); segments > 0 && step <= frames * segments; ++step) {
      const std::size_t frame = step / segments, of_frame = step % segments;
      steps.push_back(mesh.steps[frame % 2 == 0 ? of_frame : segments - of_frame]);
    }
  }
  return animation;
}

Scene frame_of(const Scene& shutter, std::size_t frame) {
  Scene scene = without_structure(shutter);
  for (Mesh& mesh : scene.meshes) {
    if (frame % 2 != 0) std::ranges::reverse(mesh.steps);
  }
  return scene;
}

Scene in_pieces(Scene scene) {
  constexpr std::size_t kMostSegments = kMaxSceneSteps - 1;
  std::vector<Mesh> pieces;
  for (Mesh& mesh : scene.meshes) {
    const std::size_t segments = mesh.segment_count();
    if (segments <= kMostSegments) {
      pieces.push_back(std::move(mesh));
      continue;
    }
    std::vector<float> times;
    for (std::size_t step = 0; step <= segments; ++step)
      times.push_back(static_cast<float>(mesh.step_time(step)));
    const std::vector<VertexBuffer> steps = std::exchange(mesh.steps, {});
    for (std::size_t first = 0; first < segments; first += kMostSegments) {
      const std::size_t last = std::min(first + kMostSegments, segments);

      Mesh& piece = pieces.emplace_back(mesh);
      piece.steps.assign(steps.begin() + static_cast<std::ptrdiff_t>(first),
                         steps.begin() + static_cast<std::ptrdiff_t>(last + 1));
      piece.time_range = {times[first], times[last]};
    }
  }
  scene.meshes = std::move(pieces);
  return scene;
}

}  // namespace stbvh::harness
