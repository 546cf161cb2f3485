/// The vertices of a leaf at the time of a ray.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "layout/layout.h"
#include "layout/leaf_segment.h"
#include "traverse/ray_setup.inl"

namespace stbvh {
namespace {

/// Vertices of a leaf relative to the ray's origin at the ray's time; each test has its own order of axes.
struct LeafVertices {
  F32x8 x, y, z;
};

/// Which vertices of the mesh an indexed leaf has; unused slots repeat one.
struct LeafVertexIds {
  std::uint32_t ids[kWidth];

  LeafVertexIds(const LeafHeader& leaf, const MeshRecord& mesh) {
    const char* const indices = static_cast<const char*>(mesh.indices);
    std::uint32_t corners[3];
    for (std::size_t i = leaf.triangle_count; i-- > 0;) {
      std::memcpy(corners, indices + leaf.prim_ids[i] * mesh.index_stride, sizeof corners);
      if (i + 1 == leaf.triangle_count) std::fill_n(ids, kWidth, corners[0]);
      for (std::size_t corner = 0; corner < 3; ++corner) ids[leaf.corners[corner][i]] = corners[corner];
    }
  }
};

/// Reads the vertices of an indexed leaf at one step from the caller's buffer.
inline void gather_step(const VertexBufferView& buffer, const LeafVertexIds& vertices, StepVertices& out) {
  const char* data = static_cast<const char*>(buffer.data);
  for (std::size_t slot = 0; slot < kWidth; ++slot) {
    float p[3];
    std::memcpy(p, data + vertices.ids[slot] * buffer.stride, sizeof p);
    out.position[0][slot] = p[0];
    out.position[1][slot] = p[1];
    out.position[2][slot] = p[2];
  }
}

/// The steps that a leaf's vertices move between at the time of a ray; both are the same at rest.
struct LeafMotion {
  const StepVertices* begin;
  const StepVertices* end;
  float fraction;
  alignas(32) StepVertices gathered[2];  ///< of an indexed leaf
};

inline void load_motion(float time, const LeafHeader& leaf, const MeshRecord& mesh, LeafMotion& motion) {
  const bool is_static = mesh.grid.is_static();
  const SegmentTime at = is_static ? SegmentTime{0, 0.0f} : segment_of(leaf, mesh, time);
  motion.fraction = at.fraction;
  if (leaf.indexed) {
    const LeafVertexIds vertices(leaf, mesh);
    gather_step(mesh.steps[at.segment], vertices, motion.gathered[0]);
    if (!is_static) gather_step(mesh.steps[at.segment + 1], vertices, motion.gathered[1]);
    motion.begin = motion.gathered;
  } else {
    motion.begin = reinterpret_cast<const StepVertices*>(&leaf + 1) + (at.segment - leaf.first_segment);
  }
  motion.end = is_static ? motion.begin : motion.begin + 1;
}

template <typename Test>
inline LeafVertices load_leaf(const TraversalRay& ray, const LeafHeader& leaf, const MeshRecord& mesh) {
  LeafMotion motion;
  load_motion(ray.time, leaf, mesh, motion);
  if (motion.begin == motion.end) return Test::at_rest(ray, *motion.begin);
  return Test::interpolated(ray, *motion.begin, *motion.end, motion.fraction);
}

}  // namespace
}  // namespace stbvh
