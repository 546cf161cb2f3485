#include "harness/scenes/frozen_scene.h"

#include <cstdint>

#include "harness/scenes/moving_triangle.h"

namespace stbvh::harness {

Scene frozen(const Scene& scene, float time) {
  Scene still;
  still.name = scene.name;
  still.camera = scene.camera_at(time);
  still.directional_lights = scene.directional_lights;
  still.point_lights = scene.point_lights;
  still.environment = scene.environment;
  for (const Mesh& mesh : scene.meshes) {
    if (!is_visible_at(mesh, time)) continue;
    const MotionSample sample = motion_sample(mesh, time);
    Mesh& copy = still.meshes.emplace_back();
    copy.name = mesh.name;
    copy.indices = mesh.indices;
    copy.mask = mesh.mask;
    copy.material = mesh.material;
    VertexBuffer& positions = copy.steps.emplace_back(mesh.steps.front().size());
    for (std::uint32_t i = 0; i < positions.size(); ++i)
      positions[i] = to_float(position_at(mesh, i, sample));
  }
  return still;
}

}  // namespace stbvh::harness
