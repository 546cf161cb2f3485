#include "layout/meshlet.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace stbvh {

namespace {

LeafHeader leaf_header(std::uint32_t mesh, const Meshlet& meshlet) {
  LeafHeader header{};
  header.mesh = mesh;
  header.triangle_count = meshlet.triangle_count;
  std::memcpy(header.corners, meshlet.corners, sizeof header.corners);
  std::copy_n(meshlet.prims, meshlet.triangle_count, header.prim_ids);
  return header;
}

/// Unused slots repeat the first vertex.
std::array<std::uint32_t, kWidth> vertex_slots(const Meshlet& meshlet) {
  std::array<std::uint32_t, kWidth> vertices;
  vertices.fill(meshlet.vertices[0]);
  std::copy_n(meshlet.vertices, meshlet.vertex_count, vertices.begin());
  return vertices;
}

}  // namespace

void write_inline_leaf(std::uint32_t mesh, const Meshlet& meshlet, std::size_t first_step,
                       std::span<const VertexBufferView> steps, std::byte* out) {
  LeafHeader header = leaf_header(mesh, meshlet);
  header.first_segment = static_cast<std::uint16_t>(first_step);
  std::memcpy(out, &header, sizeof header);
  out += sizeof header;
  const std::array<std::uint32_t, kWidth> vertices = vertex_slots(meshlet);
  for (const VertexBufferView& step : steps) {
    StepVertices positions;
    for (std::size_t slot = 0; slot < kWidth; ++slot) {
      const Vec3f p = step.position(vertices[slot]);
      positions.position[0][slot] = p.x;
      positions.position[1][slot] = p.y;
      positions.position[2][slot] = p.z;
    }
    std::memcpy(out, &positions, sizeof positions);
    out += sizeof positions;
  }
}

void write_indexed_leaf(std::uint32_t mesh, const Meshlet& meshlet, std::byte* out) {
  LeafHeader header = leaf_header(mesh, meshlet);
  header.indexed = 1;
  std::memcpy(out, &header, sizeof header);
}

}  // namespace stbvh
