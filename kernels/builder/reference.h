/// A reference: a meshlet together with the time range in which a subtree holds it.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "builder/linear_bounds.h"
#include "builder/mesh_set.h"

namespace stbvh {

/// Linear bounds over the time range of the set that holds the reference (not stored), and whose they are:
/// the fourth lanes of the corners at its begin carry the ids.
struct Reference {
  float lower_begin[3];
  std::uint32_t meshlet;
  float upper_begin[3];
  std::uint32_t mesh;
  float lower_end[4];
  float upper_end[4];

  LinearBounds bounds() const {
    // The ids must not be taken for floats: as such they are denormal, and slow on some processors.
    const __m128 xyz = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
    return {_mm_and_ps(_mm_loadu_ps(lower_begin), xyz), _mm_and_ps(_mm_loadu_ps(upper_begin), xyz),
            _mm_loadu_ps(lower_end), _mm_loadu_ps(upper_end)};
  }
};
static_assert(sizeof(Reference) == 64);

/// The times at which bounds of a mesh over a time range must hold, and where its vertices are then: at both
/// ends of the range and at every step inside it (all motion is linear in between).
struct MotionSamples {
  struct Sample {
    float parameter;  ///< of the range, in [0, 1]
    float fraction;   ///< of the segment; 0: exactly at the step
    std::uint32_t segment;
  };
  std::array<Sample, kMaxSteps + 2> samples;
  std::size_t count = 0;
  bool covers_range = true;  ///< false: the mesh is alive in a part of the range only

  /// Empty (count 0) where the mesh is not alive in `range`.
  MotionSamples(const BuildMesh& mesh, const ClosedTimeRange& range);
};

/// Boxes of the given vertices at all samples, written to `boxes` (at least samples.count), padded for the
/// rounding of the segment's fraction (docs/algorithm.md, "Why it does not leak").
void sample_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                   std::span<const std::uint32_t> vertices, std::span<BoundsSample> boxes);

/// Linear bounds of the given vertices over the range of `samples`.
LinearBounds motion_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                           std::span<const std::uint32_t> vertices);

/// Moves references towards the front of the array they stand in.
inline void move_down(const Reference* from, std::size_t count, Reference* to) {
  std::memmove(static_cast<void*>(to), from, count * sizeof(Reference));
}

Reference make_reference(const LinearBounds& bounds, std::uint32_t mesh, std::uint32_t meshlet);

}  // namespace stbvh
