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

std::optional<Meshlet> read_meshlet(const LeafHeader& leaf, const MeshView& mesh) {
  Meshlet meshlet{};
  meshlet.triangle_count = leaf.triangle_count;
  std::memcpy(meshlet.corners, leaf.corners, sizeof meshlet.corners);
  std::copy_n(leaf.prim_ids, leaf.triangle_count, meshlet.prims);
  std::array<bool, kWidth> is_known{};
  for (std::size_t i = 0; i < leaf.triangle_count; ++i) {
    const TriangleIndices triangle = mesh.triangle(leaf.prim_ids[i]);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint8_t slot = leaf.corners[corner][i];
      const std::uint32_t vertex = triangle[corner];
      if (vertex >= mesh.steps[0].count) return std::nullopt;
      if (!is_known[slot]) {
        is_known[slot] = true;
        meshlet.vertices[slot] = vertex;
        meshlet.vertex_count = std::max<std::uint8_t>(meshlet.vertex_count, slot + 1);
        continue;
      }
      if (meshlet.vertices[slot] == vertex) continue;
      for (const VertexBufferView& step : mesh.steps) {
        const Vec3f p = step.position(meshlet.vertices[slot]), q = step.position(vertex);
        if (std::memcmp(&p, &q, sizeof p) != 0) return std::nullopt;
      }
    }
  }
  return meshlet;
}

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
