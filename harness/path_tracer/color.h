/// Radiance, reflectance and throughput: three linear numbers, in the vectors that the scenes are made with.
#pragma once

#include <algorithm>
#include <cmath>

#include "harness/scenes/vec3.h"

namespace stbvh::harness {

using Color = Vec3;

/// Component by component.
inline Color modulate(Color a, Color b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline double largest(Color a) {
  return std::max({a.x, a.y, a.z});
}
/// Of linear sRGB (ITU-R BT.709).
inline double luminance(Color a) {
  return 0.2126 * a.x + 0.7152 * a.y + 0.0722 * a.z;
}
inline bool is_black(Color a) {
  return a.x == 0 && a.y == 0 && a.z == 0;
}
inline bool is_finite(Vec3 a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
/// Whether it is finite and not negative.
inline bool is_light(Color a) {
  return is_finite(a) && a.x >= 0 && a.y >= 0 && a.z >= 0;
}

}  // namespace stbvh::harness
