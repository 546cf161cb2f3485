#include "harness/scenes/scene_views.h"

namespace stbvh::harness {

SceneViews::SceneViews(const Scene& scene) : steps_(scene.meshes.size()) {
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    for (const VertexBuffer& step : mesh.steps) {
      steps_[i].push_back({.data = step.data(), .count = step.size(), .stride = sizeof(Vec3f)});
    }
    meshes_.push_back({.indices = mesh.indices.data(),
                       .triangle_count = mesh.triangle_count(),
                       .index_stride = 3 * sizeof(std::uint32_t),
                       .steps = steps_[i],
                       .time_range = mesh.time_range,
                       .step_times = mesh.step_times,
                       .mask = mesh.mask,
                       .geom_id = static_cast<std::uint32_t>(i)});
  }
}

}  // namespace stbvh::harness
