/// Groups triangles into meshlets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/welded_vertices.h"
#include "layout/meshlet.h"
#include "simd/box4.h"

namespace stbvh {

/// Groups one run of triangles.
class MeshletGrouping {
 public:
  /// At most, of all that is kept while a run is grouped.
  static constexpr std::size_t kBytesPerTriangle = 384;

  MeshletGrouping(const BuildMesh& mesh, std::span<const SortedTriangle> run);

  std::vector<Meshlet> group();

 private:
  using Boxes = std::array<Box4, kSamples>;

  void find_neighbours();
  Boxes boxes_of(std::uint32_t triangle) const;
  std::uint32_t live_neighbours(std::uint32_t triangle) const;
  std::uint32_t neighbouring_seed() const;
  std::uint32_t new_vertices(std::uint32_t triangle, std::uint32_t group) const;
  void add(Meshlet& m, std::uint32_t triangle, std::uint32_t group);
  void add_candidates(std::uint32_t vertex, std::uint32_t group);
  void grow(std::uint32_t seed);
  void merge_small();

  std::span<const SortedTriangle> run_;
  WeldedVertices vertices_;
  std::vector<std::uint32_t> triangles_;    ///< of all vertices
  std::vector<std::uint32_t> first_, end_;  ///< those of each vertex that may be unused
  std::vector<std::uint32_t> live_;         ///< unused triangles of each vertex
  std::vector<std::uint8_t> used_;
  std::vector<std::uint32_t> seen_;  ///< the last group that a triangle was a candidate of
  std::vector<std::uint32_t> vertex_group_;
  std::vector<std::uint8_t> vertex_slot_;
  std::vector<std::uint32_t> candidates_;
  std::vector<Meshlet> meshlets_;
  std::vector<Boxes> group_boxes_;
};

}  // namespace stbvh
