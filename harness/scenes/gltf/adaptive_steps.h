/// As few steps as follow a curved motion closely enough.
#pragma once

#include <vector>

#include "harness/scenes/gltf/primitive.h"
#include "harness/scenes/gltf/timeline.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::gltf {

struct AdaptiveSteps {
  std::vector<VertexBuffer> steps;
  double deviation = 0;  ///< largest distance between a vertex and its true place that was found
};

/// The least number of equidistant steps, 1 to kMaxSceneSteps, between which no vertex is further than
/// `tolerance` from its true place at the same time; kMaxSceneSteps where even those do not follow the curve.
/// The curve is looked at 9 times or more between two steps, 63 times or more in all, and at all keys.
AdaptiveSteps choose_steps(const Primitive& primitive, const Timeline& timeline, double tolerance);

}  // namespace stbvh::harness::gltf
