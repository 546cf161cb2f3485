/// Which segments of its mesh a leaf holds. Internal linkage on purpose, as in time_grid.h.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "layout/closed_time_range.h"
#include "layout/layout.h"
#include "layout/time_grid.h"

namespace stbvh {

/// Of a mesh that moves; `time` is not before the leaf's first segment.
static inline SegmentTime segment_of(const LeafHeader& leaf, const MeshRecord& mesh, float time) {
  if (mesh.grid.is_uneven()) [[unlikely]] {
    const auto last = static_cast<std::uint32_t>(-mesh.grid.segments) - 1;
    return segment_among(mesh.step_times, leaf.first_segment, last, time);
  }
  return segment_at(mesh.grid, time);
}

/// Steps that an inline leaf holds which is alive in `range`.
static inline std::size_t steps_of(const LeafHeader& leaf, const MeshRecord& mesh,
                                   const ClosedTimeRange& range) {
  if (mesh.grid.is_static()) return 1;
  return segment_of(leaf, mesh, std::min(range.last, mesh.grid.end)).segment - leaf.first_segment + 2;
}

}  // namespace stbvh
