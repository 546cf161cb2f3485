#include "harness/scenes/subdivision/degenerate_parts.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace stbvh::harness {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

Edge edge_of(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

bool has_one_twice(std::span<const std::uint32_t> corners, std::vector<std::uint32_t>& sorted) {
  sorted.assign(corners.begin(), corners.end());
  std::ranges::sort(sorted);
  return std::ranges::adjacent_find(sorted) != sorted.end();
}

/// Of all faces, sorted.
std::vector<Edge> edges_of(const SubdivisionCage& cage) {
  std::vector<Edge> edges;
  std::span<const std::uint32_t> rest = cage.face_vertices;
  for (const std::uint32_t size : cage.face_sizes) {
    const auto corners = rest.first(size);
    rest = rest.subspan(size);
    for (std::size_t i = 0; i < size; ++i) edges.push_back(edge_of(corners[i], corners[(i + 1) % size]));
  }
  std::ranges::sort(edges);
  return edges;
}

void take_out_faces(SubdivisionCage& cage, DegenerateParts& parts) {
  constexpr std::uint32_t kTakenOut = ~0u;
  std::vector<std::uint32_t> sizes, vertices, sorted, new_numbers;
  std::span<const std::uint32_t> rest = cage.face_vertices;
  for (std::uint32_t face = 0; face < cage.face_sizes.size(); ++face) {
    const auto corners = rest.first(cage.face_sizes[face]);
    rest = rest.subspan(corners.size());
    if (corners.size() < 3 || has_one_twice(corners, sorted)) {
      ++parts.faces;
      new_numbers.push_back(kTakenOut);
      continue;
    }
    new_numbers.push_back(static_cast<std::uint32_t>(sizes.size()));
    parts.numbers.push_back(face);
    sizes.push_back(cage.face_sizes[face]);
    vertices.insert(vertices.end(), corners.begin(), corners.end());
  }
  vertices.insert(vertices.end(), rest.begin(), rest.end());
  cage.face_sizes = std::move(sizes);
  cage.face_vertices = std::move(vertices);
  for (std::uint32_t& hole : cage.holes) {
    if (hole < new_numbers.size()) hole = new_numbers[hole];
  }
  std::erase(cage.holes, kTakenOut);
}

void take_out_creases(SubdivisionCage& cage, DegenerateParts& parts) {
  if (cage.edge_creases.empty() || cage.steps.empty()) return;
  const std::vector<Edge> edges = edges_of(cage);
  const std::size_t vertices = cage.steps.front().size();
  parts.creases = std::erase_if(cage.edge_creases, [&](const SubdivisionCage::Crease& crease) {
    return std::max(crease.a, crease.b) < vertices &&
           !std::ranges::binary_search(edges, edge_of(crease.a, crease.b));
  });
}

}  // namespace

DegenerateParts take_out_degenerate_parts(SubdivisionCage& cage) {
  DegenerateParts parts;
  const std::size_t corners = std::accumulate(cage.face_sizes.begin(), cage.face_sizes.end(), std::size_t{0});
  if (corners > cage.face_vertices.size()) return parts;
  take_out_faces(cage, parts);
  take_out_creases(cage, parts);
  return parts;
}

}  // namespace stbvh::harness
