/// Eight floats and eight flags in plain C++: the twin of the vector versions, operation for operation, and
/// as they of internal linkage.
#pragma once

#define STBVH_F32X8

#include <cmath>
#include <cstdint>

namespace stbvh {
namespace {

struct F32x8 {
  float v[8];
};
struct Mask8 {
  unsigned bits;
};

template <typename Op>
inline F32x8 each_lane(Op op) {
  F32x8 r;
  for (int i = 0; i < 8; ++i) r.v[i] = op(i);
  return r;
}
template <typename Op>
inline Mask8 each_flag(Op op) {
  unsigned bits = 0;
  for (int i = 0; i < 8; ++i) bits |= static_cast<unsigned>(op(i)) << i;
  return {bits};
}

inline F32x8 load(const float* p) {
  return each_lane([p](int i) { return p[i]; });
}
inline F32x8 splat(float x) {
  return each_lane([x](int) { return x; });
}
inline void store(float* p, const F32x8& a) {
  for (int i = 0; i < 8; ++i) p[i] = a.v[i];
}
inline F32x8 operator+(const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return a.v[i] + b.v[i]; });
}
inline F32x8 operator-(const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return a.v[i] - b.v[i]; });
}
inline F32x8 operator*(const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return a.v[i] * b.v[i]; });
}
inline F32x8 min(const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
}
inline F32x8 max(const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
}
inline F32x8 multiply_add(const F32x8& a, const F32x8& b, const F32x8& c) {
  return each_lane([&](int i) { return a.v[i] * b.v[i] + c.v[i]; });
}
inline F32x8 multiply_subtract(const F32x8& a, const F32x8& b, const F32x8& c) {
  return each_lane([&](int i) { return a.v[i] * b.v[i] - c.v[i]; });
}
inline F32x8 operator/(const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return a.v[i] / b.v[i]; });
}
inline F32x8 flip_sign(const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return std::signbit(b.v[i]) ? -a.v[i] : a.v[i]; });
}
inline F32x8 select_by_sign(const F32x8& sign, const F32x8& a, const F32x8& b) {
  return each_lane([&](int i) { return std::signbit(sign.v[i]) ? b.v[i] : a.v[i]; });
}
inline Mask8 less_equal(const F32x8& a, const F32x8& b) {
  return each_flag([&](int i) { return a.v[i] <= b.v[i]; });
}
inline Mask8 less(const F32x8& a, const F32x8& b) {
  return each_flag([&](int i) { return a.v[i] < b.v[i]; });
}
inline Mask8 straddles_zero(const F32x8& lowest, const F32x8& highest) {
  return each_flag([&](int i) { return lowest.v[i] < 0.0f && highest.v[i] > 0.0f; });
}

struct Slots8 {
  std::uint8_t v[8];
};
inline Slots8 load_slots(const std::uint8_t* p) {
  Slots8 s;
  for (int i = 0; i < 8; ++i) s.v[i] = p[i];
  return s;
}
inline F32x8 permute(const F32x8& a, const Slots8& slots) {
  return each_lane([&](int i) { return a.v[slots.v[i]]; });
}

}  // namespace
}  // namespace stbvh
