/// Linear bounds of vertices that move from step to step.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/build_mesh.h"
#include "builder/tightest_bounds.h"
#include "layout/linear_bounds.h"

namespace stbvh {

/// The times at which bounds of a mesh over a time range must hold, and where its vertices are then: at both
/// ends of the range and at every step inside it (all motion is linear in between).
struct MotionSamples {
  struct Sample {
    float parameter;  ///< of the range, in [0, 1]
    float fraction;   ///< of the segment; 0: exactly at the step
    std::uint32_t segment;
  };
  std::vector<Sample> samples;
  bool covers_range = true;  ///< false: the mesh is alive in a part of the range only

  /// Empty where the mesh is not alive in `range`.
  MotionSamples(const BuildMesh& mesh, const ClosedTimeRange& range);

  bool empty() const { return samples.empty(); }
};

/// Boxes of the given vertices at all samples, as many as `boxes` has, padded for the rounding of the
/// segment's fraction (docs/accuracy.md).
void sample_boxes(const BuildMesh& mesh, const MotionSamples& samples,
                  std::span<const std::uint32_t> vertices, std::span<BoundsSample> boxes);

/// Linear bounds of them over the range of `samples`.
LinearBounds motion_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                           std::span<const std::uint32_t> vertices);

}  // namespace stbvh
