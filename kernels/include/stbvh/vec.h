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

  /// Makes it as large as it must be to hold `other`.
  constexpr void extend(const Box3f& other) {
    const auto least = [](float a, float b) { return b < a ? b : a; };
    const auto greatest = [](float a, float b) { return a < b ? b : a; };
    const Vec3f &l = other.lower, &u = other.upper;
    lower = {least(lower.x, l.x), least(lower.y, l.y), least(lower.z, l.z)};
    upper = {greatest(upper.x, u.x), greatest(upper.y, u.y), greatest(upper.z, u.z)};
  }
  constexpr void extend(const Vec3f& point) { extend(Box3f{point, point}); }
};

/// Closed interval of global ray time.
struct TimeRange {
  float begin = 0.0f;
  float end = 1.0f;
};

}  // namespace stbvh
