/// Vectors, rotations and affine maps in double precision, as glTF defines them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace stbvh::harness::gltf {

using Vec3 = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  ///< x, y, z, w

/// Rows of a 3x4 matrix: p -> A p + t.
struct Affine {
  std::array<std::array<double, 4>, 3> row{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

  Vec3 apply(const Vec3& p) const {
    Vec3 q;
    for (std::size_t i = 0; i < 3; ++i) {
      q[i] = row[i][0] * p[0] + row[i][1] * p[1] + row[i][2] * p[2] + row[i][3];
    }
    return q;
  }

  void add_scaled(const Affine& other, double factor) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 4; ++j) row[i][j] += factor * other.row[i][j];
    }
  }

  static Affine zero() { return {{{{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}}}}; }

  /// From glTF's 16 numbers, column by column; the last row is (0, 0, 0, 1) by the specification.
  static Affine from_columns(std::span<const double, 16> m) {
    Affine a;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 4; ++j) a.row[i][j] = m[4 * j + i];
    }
    return a;
  }
};

inline Affine operator*(const Affine& a, const Affine& b) {
  Affine c;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      c.row[i][j] = a.row[i][0] * b.row[0][j] + a.row[i][1] * b.row[1][j] + a.row[i][2] * b.row[2][j];
    }
    c.row[i][3] += a.row[i][3];
  }
  return c;
}

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
