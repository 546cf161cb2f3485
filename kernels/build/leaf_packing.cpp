#include "build/leaf_packing.h"

#include <bit>
#include <cstring>

namespace stbvh {

namespace {

bool same_position(const BuildMesh& mesh, const BuildMesh::SegmentRange& segments, std::uint32_t a,
                   std::uint32_t b) {
  const std::uint32_t last_step = mesh.is_static() ? 0 : segments.last + 1;
  for (std::uint32_t step = segments.first; step <= last_step; ++step) {
    const Vec3f p = mesh.position(step, a);
    const Vec3f q = mesh.position(step, b);
    if (std::memcmp(&p, &q, sizeof p) != 0) return false;
  }
  return true;
}

/// Slot of `vertex` in the leaf, added if need be; kWidth if there is no room.
template <typename Same>
std::uint8_t find_or_add(BinaryLeaf& leaf, std::uint32_t vertex, const Same& same) {
  for (std::uint8_t slot = 0; slot < leaf.vertex_count; ++slot) {
    if (same(leaf.vertices[slot], vertex)) return slot;
  }
  if (leaf.vertex_count < kWidth) leaf.vertices[leaf.vertex_count] = vertex;
  return leaf.vertex_count < kWidth ? leaf.vertex_count++ : static_cast<std::uint8_t>(kWidth);
}

template <typename Same>
bool fill(BinaryLeaf& leaf, const BuildMesh& mesh, const ReferenceSet& set, const Same& same) {
  leaf.triangle_count = static_cast<std::uint8_t>(set.size());
  leaf.vertex_count = 0;
  for (std::size_t i = 0; i < set.size(); ++i) {
    leaf.prims[i] = set.references[i].prim;
    const BuildMesh::Triangle triangle = mesh.triangle(leaf.prims[i]);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint8_t slot = find_or_add(leaf, triangle.vertex[corner], same);
      if (slot == kWidth) return false;
      leaf.corners[corner][i] = slot;
    }
  }
  return true;
}

}  // namespace

std::optional<BinaryLeaf> pack_leaf(const BuildContext& context, const ReferenceSet& set) {
  if (set.size() > kWidth) return std::nullopt;
  BinaryLeaf leaf{};
  leaf.mesh = set.references[0].mesh;
  for (const Reference& reference : set.references) {
    if (reference.mesh != leaf.mesh) return std::nullopt;
  }
  const BuildMesh& mesh = context.meshes[leaf.mesh];
  if (!mesh.is_static()) leaf.segments = mesh.segments_in(set.range);
  if (fill(leaf, mesh, set, std::equal_to<std::uint32_t>())) return leaf;
  const auto same = [&](std::uint32_t a, std::uint32_t b) {
    return a == b || same_position(mesh, leaf.segments, a, b);
  };
  if (fill(leaf, mesh, set, same)) return leaf;
  return std::nullopt;
}

LinearBounds leaf_bounds(const BuildContext& context, const BinaryLeaf& leaf, const ClosedTimeRange& range) {
  const BuildMesh& mesh = context.meshes[leaf.mesh];
  const std::span<const std::uint32_t> vertices(leaf.vertices, leaf.vertex_count);
  return motion_bounds(mesh, MotionSamples(mesh, range), vertices, tightest_at_centre);
}

}  // namespace stbvh
