/// The vertices of some triangles of a mesh, those that never differ in position as one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/index_table.h"
#include "builder/sampled_steps.h"
#include "builder/triangle_order.h"
#include "simd/f32x4.h"

namespace stbvh {

class WeldedVertices {
 public:
  WeldedVertices(const BuildMesh& mesh, std::span<const SortedTriangle> run);

  std::size_t size() const { return vertices_.size(); }
  /// Of a triangle of the run, as indices into these vertices.
  const TriangleIndices& corners(std::size_t triangle) const { return corners_[triangle]; }
  std::span<const TriangleIndices> corners() const { return corners_; }
  /// Which vertex of the mesh it is.
  std::uint32_t operator[](std::size_t vertex) const { return vertices_[vertex]; }
  F32x4 position(std::size_t sample, std::size_t vertex) const { return positions_[sample][vertex]; }

 private:
  std::uint32_t canonical_vertex(IndexTable& by_position, std::uint32_t vertex,
                                 const std::array<std::size_t, kSamples>& steps);

  const BuildMesh& mesh_;
  std::vector<std::uint32_t> vertices_;
  std::vector<F32x4> positions_[kSamples];
  std::vector<TriangleIndices> corners_;
};

}  // namespace stbvh
