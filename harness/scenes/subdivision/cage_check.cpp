#include "harness/scenes/subdivision/cage_check.h"

#include <algorithm>
#include <limits>

namespace stbvh::harness::subdivision {
namespace {

/// OpenSubdiv counts in int, and the corners of a face and edges of a vertex in 16 bits.
constexpr std::size_t kMostVertices = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kMostCorners = std::numeric_limits<std::uint16_t>::max();

void check_faces(const SubdivisionCage& cage, std::size_t vertex_count) {
  if (cage.face_sizes.empty()) fail("the cage has no faces");
  if (cage.face_vertices.size() > kMostVertices) fail("the cage has {} corners", cage.face_vertices.size());
  std::size_t first = 0;
  std::vector<std::uint32_t> sorted;
  for (std::size_t face = 0; face < cage.face_sizes.size(); ++face) {
    const std::size_t size = cage.face_sizes[face];
    if (size < 3 || size > kMostCorners) {
      fail("face {} of the cage has {} corners, but 3 to {} are possible", face, size, kMostCorners);
    }
    if (cage.scheme == SubdivisionCage::Scheme::kLoop && size != 3) {
      fail("face {} of the cage has {} corners, but Loop's surfaces have triangles", face, size);
    }
    if (size > cage.face_vertices.size() - first) {
      fail("the faces of the cage have more corners than the {} that are given", cage.face_vertices.size());
    }
    const auto begin = cage.face_vertices.begin() + static_cast<std::ptrdiff_t>(first);
    sorted.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
    std::sort(sorted.begin(), sorted.end());
    if (sorted.back() >= vertex_count) {
      fail("face {} of the cage has vertex {}, but there are only {} vertices", face, sorted.back(),
           vertex_count);
    }
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) fail("face {} of the cage has vertex {} twice", face, *twice);
    first += size;
  }
  if (first != cage.face_vertices.size()) {
    fail("the faces of the cage have {} corners, but {} are given", first, cage.face_vertices.size());
  }
}

/// It looks for each of a vertex's edges among the others, so it would only refuse them after minutes.
void check_valences(const SubdivisionCage& cage, std::size_t vertex_count) {
  std::vector<std::size_t> faces(vertex_count, 0);
  for (const std::uint32_t vertex : cage.face_vertices) ++faces[vertex];
  const auto most = std::max_element(faces.begin(), faces.end());
  if (*most > kMostCorners) {
    fail("vertex {} of the cage has {} faces, but at most {} are possible", most - faces.begin(), *most,
         kMostCorners);
  }
}

void check_steps(const std::vector<VertexBuffer>& steps) {
  if (steps.empty() || steps.size() > kMaxSteps) {
    fail("the cage has {} steps, but 1 to {} are possible", steps.size(), kMaxSteps);
  }
  if (steps.front().size() > kMostVertices) fail("the cage has {} vertices", steps.front().size());
  for (std::size_t s = 0; s < steps.size(); ++s) {
    if (steps[s].size() != steps.front().size()) {
      fail("step {} of the cage has {} vertices, step 0 has {}", s, steps[s].size(), steps.front().size());
    }
  }
}

void check_sharpness(float sharpness) {
  if (!(sharpness >= 0)) fail("a crease of the cage has the sharpness {}, but 0 is the least", sharpness);
}

void check_creases(const SubdivisionCage& cage, std::size_t vertex_count) {
  for (const SubdivisionCage::Crease& crease : cage.edge_creases) {
    check_sharpness(crease.sharpness);
    if (std::max(crease.a, crease.b) >= vertex_count) {
      fail("a crease of the cage has vertex {}, but there are only {} vertices", std::max(crease.a, crease.b),
           vertex_count);
    }
  }
  for (const SubdivisionCage::Corner& corner : cage.vertex_creases) {
    check_sharpness(corner.sharpness);
    if (corner.vertex >= vertex_count) {
      fail("a vertex crease of the cage has vertex {}, but there are only {} vertices", corner.vertex,
           vertex_count);
    }
  }
  for (const std::uint32_t hole : cage.holes) {
    if (hole >= cage.face_sizes.size()) {
      fail("face {} of the cage is a hole, but there are only {} faces", hole, cage.face_sizes.size());
    }
  }
}

}  // namespace

void check_cage(const SubdivisionCage& cage) {
  check_steps(cage.steps);
  const std::size_t vertex_count = cage.steps.front().size();
  check_faces(cage, vertex_count);
  check_valences(cage, vertex_count);
  check_creases(cage, vertex_count);
}

}  // namespace stbvh::harness::subdivision
