/// Affine maps in double precision.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// Rows of a 3x4 matrix: p -> A p + t.
struct Affine {
  std::array<std::array<double, 4>, 3> row{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

  Vec3 apply(Vec3 p) const {
    const auto along = [&](const std::array<double, 4>& r) {
      return r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3];
    };
    return {along(row[0]), along(row[1]), along(row[2])};
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

}  // namespace stbvh::harness
