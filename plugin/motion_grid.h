/// The steps and boxes of the user geometry, from those of its meshes.
#pragma once

#include <span>
#include <vector>

#include "stbvh/mesh_view.h"

namespace stbvh::plugin {

/// Boxes of one mesh at its steps; one step: static, for all times.
struct MeshMotion {
  std::vector<Box3f> steps;
  TimeRange time_range;
  std::vector<float> step_times = {};  ///< empty: equidistant
};

/// What Embree is told: boxes equidistant over `time_range`; between two of them Embree interpolates.
struct MotionGrid {
  TimeRange time_range;
  std::vector<Box3f> steps;
};

/// A grid whose interpolated boxes contain every mesh at every time in [0, 1] at which that mesh is alive.
///
/// One mesh keeps its own grid and exact boxes. Several moving meshes get a common grid, as fine as the
/// finest of them if 128 segments allow it, and the tightest boxes at the grid's times that hold, by the
/// smallest shift of both ends of a segment where a mesh bulges between them; padded for the rounding of all
/// time arithmetic. Meshes with empty boxes, and those that are never alive in [0, 1], do not count; without
/// others the one box is empty.
MotionGrid fit_motion_grid(std::span<const MeshMotion> meshes);

}  // namespace stbvh::plugin
