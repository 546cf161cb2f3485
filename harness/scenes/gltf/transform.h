/// Vectors, rotations and affine maps in double precision, as glTF defines them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "harness/scenes/affine.h"

namespace stbvh::harness::gltf {

using Vec3 = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  ///< x, y, z, w

/// Unit length; the identity where the length is zero or not finite.
inline Quaternion normalized(const Quaternion& q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(length > 0) || !std::isfinite(length)) return {0, 0, 0, 1};
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

/// Along the shorter arc, at constant speed.
inline Quaternion slerp(const Quaternion& from, const Quaternion& to, double f) {
  const Quaternion a = normalized(from);
  Quaternion b = normalized(to);
  double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  if (cosine < 0) {
    cosine = -cosine;
    for (double& x : b) x = -x;
  }
  // Below an angle of 1e-4 the chord and the arc agree to better than 1e-8 of that angle.
  double wa = 1 - f, wb = f;
  if (cosine < 1 - 5e-9) {
    const double angle = std::acos(cosine);
    wa = std::sin((1 - f) * angle) / std::sin(angle);
    wb = std::sin(f * angle) / std::sin(angle);
  }
  return normalized(
      {wa * a[0] + wb * b[0], wa * a[1] + wb * b[1], wa * a[2] + wb * b[2], wa * a[3] + wb * b[3]});
}

/// A node's own transform: scale, then rotation, then translation.
struct TranslationRotationScale {
  Vec3 translation{0, 0, 0};
  Quaternion rotation{0, 0, 0, 1};
  Vec3 scale{1, 1, 1};

  Affine matrix() const {
    const auto [x, y, z, w] = normalized(rotation);
    const std::array<Vec3, 3> r{{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                                 {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                                 {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
    Affine a;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) a.row[i][j] = r[i][j] * scale[j];
      a.row[i][3] = translation[i];
    }
    return a;
  }
};

}  // namespace stbvh::harness::gltf
