/// Affine maps in double precision.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace stbvh::harness {

/// Rows of a 3x4 matrix: p -> A p + t.
struct Affine {
  std::array<std::array<double, 4>, 3> row{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

  std::array<double, 3> apply(const std::array<double, 3>& p) const {
    std::array<double, 3> q;
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

}  // namespace stbvh::harness
