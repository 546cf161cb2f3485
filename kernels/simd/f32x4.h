/// Four floats for builders and bounds: x, y, z and a lane that carries nothing (SSE2, the baseline of
/// x86-64).
#pragma once

#include <emmintrin.h>

#include "stbvh/vec.h"

namespace stbvh {

struct F32x4 {
  __m128 v;

  F32x4() = default;
  F32x4(__m128 value) : v(value) {}  // NOLINT(google-explicit-constructor): a wrapper of exactly this
  explicit F32x4(float value) : v(_mm_set1_ps(value)) {}
  F32x4(float x, float y, float z) : v(_mm_set_ps(0.0f, z, y, x)) {}
  explicit F32x4(const Vec3f& p) : F32x4(p.x, p.y, p.z) {}

  float operator[](int lane) const {
    alignas(16) float lanes[4];
    _mm_store_ps(lanes, v);
    return lanes[lane];
  }
};

inline F32x4 operator+(F32x4 a, F32x4 b) {
  return _mm_add_ps(a.v, b.v);
}
inline F32x4 operator-(F32x4 a, F32x4 b) {
  return _mm_sub_ps(a.v, b.v);
}
inline F32x4 operator*(F32x4 a, F32x4 b) {
  return _mm_mul_ps(a.v, b.v);
}
inline F32x4 min(F32x4 a, F32x4 b) {
  return _mm_min_ps(a.v, b.v);
}
inline F32x4 max(F32x4 a, F32x4 b) {
  return _mm_max_ps(a.v, b.v);
}
inline F32x4 abs(F32x4 a) {
  return _mm_andnot_ps(_mm_set1_ps(-0.0f), a.v);
}
/// Whether all of x, y, z are equal.
inline bool equal3(F32x4 a, F32x4 b) {
  return (_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v)) & 7) == 7;
}

/// Whether x, y, z are all below those of b; not where NaN.
inline bool below3(F32x4 a, F32x4 b) {
  return (_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v)) & 7) == 7;
}

/// x*y + y*z + z*x: half the surface area of a box of that size.
inline float half_area(F32x4 size) {
  const __m128 yzx = _mm_shuffle_ps(size.v, size.v, _MM_SHUFFLE(3, 0, 2, 1));
  const __m128 p = _mm_mul_ps(size.v, yzx);
  const __m128 s = _mm_add_ss(_mm_add_ss(p, _mm_shuffle_ps(p, p, 1)), _mm_movehl_ps(p, p));
  return _mm_cvtss_f32(s);
}

}  // namespace stbvh
