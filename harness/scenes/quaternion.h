/// Rotations in double precision.
#pragma once

#include <algorithm>
#include <cmath>

#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// A rotation where it has unit length.
struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

inline Quaternion axis_angle(Vec3 axis, double radians) {
  const Vec3 n = normalize(axis) * std::sin(radians / 2);
  return {std::cos(radians / 2), n.x, n.y, n.z};
}

/// `a` after `b`.
inline Quaternion operator*(Quaternion a, Quaternion b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

inline Quaternion conjugate(Quaternion a) {
  return {a.w, -a.x, -a.y, -a.z};
}

inline Vec3 rotate(Quaternion q, Vec3 v) {
  const Vec3 n{q.x, q.y, q.z};
  const Vec3 t = cross(n, v) * 2.0;
  return v + t * q.w + cross(n, t);
}

inline double dot(Quaternion a, Quaternion b) {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

/// Unit length, whatever the length is. Not a number where a component is not finite, and where all are zero:
/// that is no rotation, and whoever takes it for one would show something in a place that no file names.
inline Quaternion normalized(Quaternion q) {
  const double largest = std::max({std::abs(q.w), std::abs(q.x), std::abs(q.y), std::abs(q.z)});
  const Quaternion near{q.w / largest, q.x / largest, q.y / largest, q.z / largest};  // squares are in range
  const double length = std::sqrt(dot(near, near));
  return {near.w / length, near.x / length, near.y / length, near.z / length};
}

/// Along the shorter arc, at constant speed.
inline Quaternion slerp(Quaternion from, Quaternion to, double f) {
  const Quaternion a = normalized(from), b = normalized(to);
  const double cosine = std::abs(dot(a, b));
  // Below an angle of 1e-4 the chord and the arc agree to better than 1e-8 of that angle.
  double wa = 1 - f, wb = f;
  if (cosine < 1 - 5e-9) {
    const double angle = std::acos(cosine);
    wa = std::sin((1 - f) * angle) / std::sin(angle);
    wb = std::sin(f * angle) / std::sin(angle);
  }
  if (dot(a, b) < 0) wb = -wb;
  return normalized({wa * a.w + wb * b.w, wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z});
}

}  // namespace stbvh::harness
