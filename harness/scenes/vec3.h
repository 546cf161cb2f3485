/// Vectors in double precision, in which scenes, rays, pictures and the truth are worked out.
#pragma once

#include <cmath>
#include <numbers>

#include "stbvh/vec.h"

namespace stbvh::harness {

inline constexpr double kPi = std::numbers::pi;

struct Vec2 {
  double x = 0, y = 0;
};
struct Vec3 {
  double x = 0, y = 0, z = 0;
};

inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator-(Vec3 a) {
  return {-a.x, -a.y, -a.z};
}
inline Vec3 operator*(Vec3 a, double s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vec3 operator*(double s, Vec3 a) {
  return a * s;
}
inline double dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vec3 a) {
  return std::sqrt(dot(a, a));
}
/// Unit vector along `a`; the x axis for the zero vector.
inline Vec3 normalize(Vec3 a) {
  const double l = length(a);
  return l > 0 ? a * (1 / l) : Vec3{1, 0, 0};
}
inline double lerp(double a, double b, double f) {
  return a + (b - a) * f;
}
inline Vec3 lerp(Vec3 a, Vec3 b, double f) {
  return a + (b - a) * f;
}
/// 0 below `a`, 1 above `b`, a cubic in between.
inline double smoothstep(double a, double b, double x) {
  const double f = std::fmin(1.0, std::fmax(0.0, (x - a) / (b - a)));
  return f * f * (3 - 2 * f);
}
inline Vec3f to_float(Vec3 a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}
inline Vec3 to_double(Vec3f a) {
  return {a.x, a.y, a.z};
}
/// Some unit vector at right angles to the unit vector `a`.
inline Vec3 perpendicular(Vec3 a) {
  const Vec3 helper = std::abs(a.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return normalize(cross(a, helper));
}

}  // namespace stbvh::harness
