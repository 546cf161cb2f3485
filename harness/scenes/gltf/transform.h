/// A node's own transform, as glTF defines it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "harness/scenes/affine.h"
#include "harness/scenes/quaternion.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness::gltf {

/// The quaternion of glTF's four numbers, of which w is the last.
template <class Numbers>
Quaternion to_quaternion(const Numbers& n) {
  return {n[3], n[0], n[1], n[2]};
}

/// What float cannot hold becomes infinite, which is found and left out where it is used.
inline Vec3f rounded(Vec3 v) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto coordinate = [](double x) {
    if (std::abs(x) <= double{std::numeric_limits<float>::max()} || std::isnan(x))
      return static_cast<float>(x);
    return x > 0 ? kInfinity : -kInfinity;
  };
  return {coordinate(v.x), coordinate(v.y), coordinate(v.z)};
}

/// Scale, then rotation, then translation: numbers as they stand in the file.
struct TranslationRotationScale {
  std::array<double, 3> translation{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};
  std::array<double, 3> scale{1, 1, 1};

  Affine matrix() const {
    const auto [w, x, y, z] = normalized(to_quaternion(rotation));
    Affine a{{{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), translation[0]},
               {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), translation[1]},
               {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), translation[2]}}}};
    for (std::array<double, 4>& row : a.row) {
      for (std::size_t j = 0; j < 3; ++j) row[j] *= scale[j];
    }
    return a;
  }
};

}  // namespace stbvh::harness::gltf
