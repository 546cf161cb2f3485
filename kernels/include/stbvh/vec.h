/// Plain float vectors and boxes, as they stand in caller's buffers: no padding, no hidden initialisation.
#pragma once

#include <limits>

namespace stbvh {

struct Vec3f {
  float x, y, z;
};

/// Axis-aligned box [lower, upper]; empty where lower > upper.
struct Box3f {
  Vec3f lower, upper;

  static constexpr Box3f empty() {
    constexpr float inf = std::numeric_limits<float>::infinity();
    return {{inf, inf, inf}, {-inf, -inf, -inf}};
  }
};

/// Closed interval of global ray time.
struct TimeRange {
  float begin = 0.0f;
  float end = 1.0f;
};

}  // namespace stbvh
