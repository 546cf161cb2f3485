/// Steps at the keys of a clip, with as many between them as a curved motion needs.
#pragma once

#include <cstddef>
#include <vector>

#include "harness/scenes/gltf/primitive.h"
#include "harness/scenes/gltf/timeline.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::gltf {

struct KeySteps {
  std::vector<VertexBuffer> steps;
  std::vector<float> times;  ///< of each step in ray time
  double deviation = 0;      ///< largest distance between a vertex and its true place that was found
};

/// The first step is at the beginning of `range`, the last at its end, one at each key inside: at the float
/// nearest to it. Where something jumps, there are two, one float apart. Between two keys there are as few
/// equidistant steps as keep all vertices within `tolerance`, and what positions round by, of their true
/// places at the same time: none where the motion is straight. It is looked at 9 times or more between two
/// keys, three times or more between two steps. Where that makes more than kMaxSteps, vertices may be further
/// off, and where there are more keys than that, not each has a step. Throws Problem where the steps take
/// more than `most_bytes`.
KeySteps steps_at_keys(const Primitive& primitive, const Timeline& timeline, TimeRange range,
                       double tolerance, double most_bytes);

}  // namespace stbvh::harness::gltf
