/// Nodes, leaves and rays that stay in a first-level cache of 32 KB: the floor of the traversal is measured
/// on them, a ring at a time, again and again.
#pragma once

#include <cstddef>
#include <vector>

#include "layout/layout.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

/// Nodes, leaves or rays of a ring.
inline constexpr std::size_t kRing = 16;

/// Nodes whose eight boxes all meet `ray`, each of its children the next node of the ring.
template <typename Node>
struct NodeRing {
  NodeRing();

  alignas(64) Node nodes[kRing]{};
  StructureView structure{};
  Ray ray;
};

enum class LeafKind { kInline, kInlineStatic, kIndexed };

/// Leaves of seven triangles around their eighth vertex, over one segment or static.
class LeafRing {
 public:
  explicit LeafRing(LeafKind kind);
  LeafRing(const LeafRing&) = delete;
  LeafRing& operator=(const LeafRing&) = delete;

  const StructureView& structure() const { return structure_; }
  const LeafHeader& leaf(std::size_t i) const { return slots_[i % kRing].header; }

  /// A ray that hits one triangle of each leaf, far from its edges, and one that misses all of them clearly.
  static Ray hitting_ray();
  static Ray missing_ray();

 private:
  struct alignas(64) Slot {
    LeafHeader header;
    StepVertices steps[2];  ///< not read of indexed leaves
  };

  Slot slots_[kRing]{};
  std::vector<Vec3f> positions_[2];  ///< [step][vertex]
  VertexBufferView steps_[2];
  std::vector<TriangleIndices> triangles_;
  MeshRecord mesh_{};
  StructureView structure_{};
};

/// Rays of all octants, and a structure of which only the bounds are read.
struct RayRing {
  RayRing();

  StructureView structure{};
  Ray rays[kRing]{};
};

}  // namespace stbvh::harness
