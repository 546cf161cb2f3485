#include "harness/scenes/scene.h"

#include <algorithm>

namespace stbvh::harness {

std::size_t Scene::triangle_count() const {
  std::size_t n = 0;
  for (const Mesh& mesh : meshes) n += mesh.triangle_count();
  return n;
}

std::size_t Scene::primitive_segment_count() const {
  std::size_t n = 0;
  for (const Mesh& mesh : meshes) n += mesh.triangle_count() * std::max<std::size_t>(mesh.segment_count(), 1);
  return n;
}

std::size_t Scene::buffer_bytes() const {
  std::size_t bytes = 0;
  for (const Mesh& mesh : meshes) {
    bytes += mesh.indices.size() * sizeof(std::uint32_t);
    for (const VertexBuffer& step : mesh.steps) bytes += step.size() * sizeof(Vec3f);
  }
  return bytes;
}

Box3f Scene::bounds() const {
  Box3f box = Box3f::empty();
  for (const Mesh& mesh : meshes) {
    for (const VertexBuffer& step : mesh.steps) {
      for (const Vec3f& p : step.span()) {
        box.lower = {std::min(box.lower.x, p.x), std::min(box.lower.y, p.y), std::min(box.lower.z, p.z)};
        box.upper = {std::max(box.upper.x, p.x), std::max(box.upper.y, p.y), std::max(box.upper.z, p.z)};
      }
    }
  }
  return box;
}

}  // namespace stbvh::harness
