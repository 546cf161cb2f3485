/// A box in registers, for the builder.
#pragma once

#include <limits>

#include "simd/f32x4.h"

namespace stbvh {

struct Box4 {
  F32x4 lower, upper;

  static Box4 empty() {
    return {F32x4(std::numeric_limits<float>::infinity()), F32x4(-std::numeric_limits<float>::infinity())};
  }

  void extend(const Box4& other) {
    lower = min(lower, other.lower);
    upper = max(upper, other.upper);
  }
  void extend(F32x4 point) { extend(Box4{point, point}); }
};

inline Box3f to_box3f(const Box4& box) {
  const auto& [lower, upper] = box;
  return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

inline Box4 to_box4(const Box3f& box) {
  return {F32x4(box.lower), F32x4(box.upper)};
}

inline Box4 united(Box4 a, const Box4& b) {
  a.extend(b);
  return a;
}

}  // namespace stbvh
