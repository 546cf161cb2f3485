/// What a leaf holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "layout/layout.h"

namespace stbvh {

/// Up to eight triangles of one mesh over up to eight vertices.
struct Meshlet {
  std::uint8_t triangle_count;
  std::uint8_t vertex_count;
  std::uint8_t corners[3][kWidth];
  std::uint32_t prims[kWidth];
  std::uint32_t vertices[kWidth];

  std::span<const std::uint32_t> used_vertices() const { return {vertices, vertex_count}; }
};

/// Writes a leaf with its vertices at `steps`, of which the first is number `first_step` of the mesh.
void write_inline_leaf(std::uint32_t mesh, const Meshlet& meshlet, std::size_t first_step,
                       std::span<const VertexBufferView> steps, std::byte* out);
/// Writes a leaf that reads the caller's buffers.
void write_indexed_leaf(std::uint32_t mesh, const Meshlet& meshlet, std::byte* out);

/// What a leaf was written of, with the vertices that `mesh` has now; none where corners of one vertex slot
/// are no longer at the same place at all steps, or not there at all.
std::optional<Meshlet> read_meshlet(const LeafHeader& leaf, const MeshView& mesh);

}  // namespace stbvh
