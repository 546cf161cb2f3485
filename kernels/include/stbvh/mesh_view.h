/// What the kernels know of a mesh: pointers into the caller's buffers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "stbvh/vec.h"

namespace stbvh {

/// Most steps a mesh may have (Embree takes 129).
inline constexpr std::size_t kMaxSteps = 4096;

/// Positions are finite and smaller than this in magnitude (as in Embree), or their triangles are left out.
inline constexpr float kMaxCoordinate = 1.844e18f;

/// Whether structures take a vertex.
inline bool is_valid_position(const Vec3f& p) {
  const auto is_valid = [](float x) { return x > -kMaxCoordinate && x < kMaxCoordinate; };  // not where NaN
  return is_valid(p.x) && is_valid(p.y) && is_valid(p.z);
}

/// Vertices of one step: `count` positions of three floats, `stride` bytes apart.
struct VertexBufferView {
  const void* data = nullptr;
  std::size_t count = 0;
  std::size_t stride = sizeof(Vec3f);

  Vec3f position(std::size_t vertex) const {
    Vec3f p;
    std::memcpy(&p, static_cast<const char*>(data) + vertex * stride, sizeof p);
    return p;
  }
};

/// The vertices of a triangle.
using TriangleIndices = std::array<std::uint32_t, 3>;

/// A triangle mesh with one vertex buffer for each step, in global ray time.
///
/// With one step the mesh is static, at p_0 for all times. With more it moves linearly from step to step
/// and is not hit before the first or after the last: p(t) = (1-f) p_k + f p_{k+1} (docs/algorithm.md).
/// The buffers must live as long as a structure built from them: indexed leaves read them.
struct MeshView {
  const void* indices = nullptr;  ///< 3 x uint32 for each triangle, `index_stride` bytes apart
  std::size_t triangle_count = 0;
  std::size_t index_stride = 3 * sizeof(std::uint32_t);
  std::span<const VertexBufferView> steps;  ///< 1 to kMaxSteps buffers
  TimeRange time_range;                     ///< over which the steps are equidistant, without step_times
  std::span<const float> step_times;        ///< of each step, strictly increasing; empty: equidistant
  std::uint32_t mask = 0xFFFFFFFFu;         ///< hit only by rays with (ray.mask & mask) != 0
  std::uint32_t geom_id = 0;                ///< reported in hits

  TriangleIndices triangle(std::size_t prim) const {
    TriangleIndices triangle;
    std::memcpy(&triangle, static_cast<const char*>(indices) + prim * index_stride, sizeof triangle);
    return triangle;
  }
};

/// Whether a mesh can move over `range`: it is finite, and its length a normal float (1.18e-38) or more,
/// where denormal ends count as 0. Two steps must be as far apart.
bool is_usable(const TimeRange& range);

/// Whether `count` elements of `bytes`, `stride` > 0 bytes apart, can lie at `data`: no object takes more
/// than half of the address space.
bool fits_into_memory(const void* data, std::size_t count, std::size_t stride, std::size_t bytes);

/// What keeps a mesh from being built, in a few words behind its name ("has no steps"); null: nothing. No
/// buffer is read.
const char* problem_of(const MeshView& mesh);

}  // namespace stbvh
