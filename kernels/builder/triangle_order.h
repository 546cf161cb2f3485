/// The order in which the triangles of a mesh are grouped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "builder/build_memory.h"
#include "builder/build_mesh.h"
#include "simd/box4.h"

namespace stbvh {

struct BuildContext;

struct SortedTriangle {
  std::uint64_t key;  ///< along the curve
  std::uint32_t prim;

  bool operator<(const SortedTriangle& other) const {
    return key != other.key ? key < other.key : prim < other.prim;
  }
};

/// The valid triangles of a mesh along a space-filling curve through their centroids at one step.
class TriangleOrder {
 public:
  TriangleOrder(BuildContext& context, const BuildMesh& mesh);
  std::span<const SortedTriangle> triangles() const { return triangles_; }

 private:
  F32x4 centroid3(std::uint32_t prim) const;
  void collect_valid();
  void set_keys();

  const BuildMesh& mesh_;
  std::size_t step_;
  TemporaryArray<SortedTriangle> storage_;
  std::span<SortedTriangle> triangles_;
  Box4 centroids3_ = Box4::empty();
};

}  // namespace stbvh
