/// Hair and cloth that lag behind the skeleton they hang on.
#pragma once

#include <string>
#include <vector>

#include "harness/scenes/procedural/shared/skeleton.h"

namespace stbvh::harness {

/// A skinned shape each vertex of which is where the skeleton was `lag` (in shutter times) ago.
struct TrailingShape {
  SkinnedShape skinned;
  std::vector<double> lag;

  std::size_t triangle_count() const { return skinned.shape.triangle_count(); }
};

/// A lock of hair: a flattened, tapered tube along the polyline `path`, following `joint`, its lag growing to
/// `tip_lag` at the end.
void add_lock(TrailingShape& hair, const std::vector<Vec3>& path, double radius, std::size_t around,
              std::size_t joint, double tip_lag);

/// The mesh of `shape` at `steps` steps; `pose` is asked for times before 0 too.
Mesh trail(std::string name, const TrailingShape& shape, const Skeleton& skeleton, const PoseAt& pose,
           std::size_t steps, Vec3f color);

}  // namespace stbvh::harness
