/// The bytes of a structure: links, three kinds of nodes, two kinds of leaves, the mesh table.
///
/// Nodes and leaves stand in one block of memory, addressed in units of 32 bytes by 32-bit links whose upper
/// two bits say what the link leads to. Everything here is plain data, read by the traversal of every
/// instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layout/time_grid.h"
#include "stbvh/mesh_view.h"

namespace stbvh {

inline constexpr std::size_t kWidth = 8;            ///< children of a node, triangles and vertices of a leaf
inline constexpr std::size_t kUnitBytes = 32;       ///< granularity of links
inline constexpr std::size_t kMaxUnits = 1u << 30;  ///< 32 GiB
inline constexpr std::size_t kMaxLevels = 90;       ///< nodes above a leaf: what the traversal's stacks hold

enum class LinkKind : std::uint32_t { kStaticNode = 0, kLinearNode = 1, kSpatialTemporalNode = 2, kLeaf = 3 };

/// Kind in the upper two bits, offset in units of 32 bytes in the lower thirty.
using Link = std::uint32_t;
inline constexpr std::uint32_t kLinkKindShift = 30;
inline constexpr std::uint32_t kLinkOffsetMask = (1u << kLinkKindShift) - 1;

/// Order of the planes in a node. Empty slots are (+inf, -inf): hit by no ray.
enum Plane { kLowerX, kLowerY, kLowerZ, kUpperX, kUpperY, kUpperZ, kPlanes };

/// Child bounds without motion.
struct alignas(kUnitBytes) StaticNode {
  float planes[kPlanes][kWidth];
  Link children[kWidth];
};

/// Child bounds b(t) = planes + (t - time_begin) * slopes.
struct alignas(kUnitBytes) LinearNode {
  float planes[kPlanes][kWidth];
  float slopes[kPlanes][kWidth];
  Link children[kWidth];
  float time_begin;
  std::uint32_t unused[7];  ///< 0
};

/// Linear bounds anchored at each child's own time range; a child is alive for time_begin <= t <= time_last.
struct alignas(kUnitBytes) SpatialTemporalNode {
  float planes[kPlanes][kWidth];
  float slopes[kPlanes][kWidth];
  Link children[kWidth];
  float time_begin[kWidth];
  float time_last[kWidth];
};

static_assert(sizeof(StaticNode) == 224);
static_assert(sizeof(LinearNode) == 448);
static_assert(sizeof(SpatialTemporalNode) == 480);

/// Up to eight triangles of one mesh over up to eight vertices. What follows the header in memory:
/// inline leaf: StepVertices for each step from first_segment on (one where the mesh is static);
/// indexed leaf: nothing, its vertices are those of its triangles in the caller's buffers.
struct alignas(kUnitBytes) LeafHeader {
  std::uint32_t mesh;           ///< index into the mesh table
  std::uint16_t first_segment;  ///< the step that the first StepVertices belongs to
  std::uint8_t triangle_count;
  std::uint8_t indexed;             ///< 0: inline
  std::uint8_t corners[3][kWidth];  ///< vertex slot of each triangle's corners
  std::uint32_t prim_ids[kWidth];
};

/// Positions of a leaf's vertices at one step, by axis; unused slots repeat the first vertex.
struct StepVertices {
  float position[3][kWidth];
};

static_assert(sizeof(LeafHeader) == 64);
static_assert(sizeof(StepVertices) == 96);

constexpr std::size_t inline_leaf_bytes(std::size_t steps) {
  return sizeof(LeafHeader) + steps * sizeof(StepVertices);
}
inline constexpr std::size_t kIndexedLeafBytes = sizeof(LeafHeader);
static_assert(inline_leaf_bytes(1) == 160 && inline_leaf_bytes(2) == 256 && kIndexedLeafBytes == 64);

/// What the traversal needs to know of a mesh, or of a part that has steps of its own.
struct MeshRecord {
  TimeGrid grid;  ///< static meshes: [-inf, +inf], 0 segments
  std::uint32_t mask;
  std::uint32_t geom_id;
  const VertexBufferView* steps;  ///< read by indexed leaves, as the next two
  const void* indices;            ///< as MeshView has them
  std::size_t index_stride;
  const float* step_times;  ///< read where the grid is uneven
  std::uint32_t index;      ///< of the mesh, or of that which this is a part of, in the span given to build()
};
static_assert(sizeof(MeshRecord) == 64);

/// A structure as the traversal sees it.
struct StructureView {
  const std::byte* data;  ///< nodes and leaves
  const MeshRecord* meshes;
  Link root;
  bool empty;
  float time_begin, time_last;           ///< times at which anything is alive, within [0, 1]
  alignas(16) float lower[4], upper[4];  ///< x, y, z of the bounds of everything at all times, and a zero
};

}  // namespace stbvh
