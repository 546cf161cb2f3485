#include "builder/welded_vertices.h"

#include <bit>
#include <cstring>

namespace stbvh {

namespace {

bool same_position(const BuildMesh& mesh, std::uint32_t a, std::uint32_t b) {
  for (std::size_t step = 0; step <= mesh.segments(); ++step) {
    const Vec3f p = mesh.position(step, a);
    const Vec3f q = mesh.position(step, b);
    if (std::memcmp(&p, &q, sizeof p) != 0) return false;
  }
  return true;
}

}  // namespace

WeldedVertices::WeldedVertices(const BuildMesh& mesh, std::span<const SortedTriangle> run) : mesh_(mesh) {
  IndexTable by_id(3 * run.size());
  std::vector<std::uint32_t> ids;  // vertices of the mesh met so far
  IndexTable by_position(3 * run.size());
  const auto steps = sampled_steps(mesh_);
  corners_.resize(run.size());
  std::vector<std::uint32_t> canonical;
  for (std::size_t i = 0; i < run.size(); ++i) {
    const TriangleIndices t = mesh_.triangle(run[i].prim);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = t[corner];
      const auto added = static_cast<std::uint32_t>(ids.size());
      const std::uint32_t id =
          by_id.find_or_add(vertex, added, [&](std::uint32_t k) { return ids[k] == vertex; });
      if (id == added) {
        ids.push_back(vertex);
        canonical.push_back(canonical_vertex(by_position, vertex, steps));
      }
      corners_[i][corner] = canonical[id];
    }
  }
}

std::uint32_t WeldedVertices::canonical_vertex(IndexTable& by_position, std::uint32_t vertex,
                                               const std::array<std::size_t, kSamples>& steps) {
  // Vertices may coincide at some steps only: where all that can move start, for example.
  std::uint64_t hash = 0;
  for (const std::size_t step : {std::size_t{0}, steps[0], steps[1], mesh_.segments()}) {
    const Vec3f p = mesh_.position(step, vertex);
    for (const float x : {p.x, p.y, p.z}) {
      hash = (hash ^ std::bit_cast<std::uint32_t>(x)) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 32;
    }
  }
  const auto added = static_cast<std::uint32_t>(vertices_.size());
  const std::uint32_t index = by_position.find_or_add(
      hash, added, [&](std::uint32_t k) { return same_position(mesh_, vertices_[k], vertex); });
  if (index == added) {
    vertices_.push_back(vertex);
    for (std::size_t s = 0; s < kSamples; ++s)
      positions_[s].push_back(F32x4(mesh_.position(steps[s], vertex)));
  }
  return index;
}

}  // namespace stbvh
