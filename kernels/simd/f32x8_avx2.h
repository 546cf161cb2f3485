/// Eight floats and eight flags, AVX2 and FMA. Internal linkage: what is compiled for one instruction set
/// must not be linked into what is compiled for another.
#pragma once

#define STBVH_F32X8

#include <immintrin.h>

#include <cstdint>

namespace stbvh {
namespace {

struct F32x8 {
  __m256 v;
};
struct Mask8 {
  unsigned bits;
};

inline F32x8 load(const float* p) {
  return {_mm256_load_ps(p)};
}
inline F32x8 splat(float x) {
  return {_mm256_set1_ps(x)};
}
inline void store(float* p, F32x8 a) {
  _mm256_store_ps(p, a.v);
}
inline F32x8 operator+(F32x8 a, F32x8 b) {
  return {_mm256_add_ps(a.v, b.v)};
}
inline F32x8 operator-(F32x8 a, F32x8 b) {
  return {_mm256_sub_ps(a.v, b.v)};
}
inline F32x8 operator*(F32x8 a, F32x8 b) {
  return {_mm256_mul_ps(a.v, b.v)};
}
inline F32x8 min(F32x8 a, F32x8 b) {
  return {_mm256_min_ps(a.v, b.v)};
}
inline F32x8 max(F32x8 a, F32x8 b) {
  return {_mm256_max_ps(a.v, b.v)};
}
/// a * b + c, rounded once here (the scalar twin rounds twice: only for what is padded for either).
inline F32x8 multiply_add(F32x8 a, F32x8 b, F32x8 c) {
  return {_mm256_fmadd_ps(a.v, b.v, c.v)};
}
/// a * b - c, likewise.
inline F32x8 multiply_subtract(F32x8 a, F32x8 b, F32x8 c) {
  return {_mm256_fmsub_ps(a.v, b.v, c.v)};
}
inline F32x8 operator/(F32x8 a, F32x8 b) {
  return {_mm256_div_ps(a.v, b.v)};
}
/// a, negated where b is negative (or -0).
inline F32x8 flip_sign(F32x8 a, F32x8 b) {
  return {_mm256_xor_ps(a.v, _mm256_and_ps(b.v, _mm256_set1_ps(-0.0f)))};
}
/// b where `sign` is negative (or -0), else a.
inline F32x8 select_by_sign(F32x8 sign, F32x8 a, F32x8 b) {
  return {_mm256_blendv_ps(a.v, b.v, sign.v)};
}
inline Mask8 less_equal(F32x8 a, F32x8 b) {
  return {static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)))};
}
inline Mask8 less(F32x8 a, F32x8 b) {
  return {static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)))};
}
/// Lanes where min < 0 < max; false where either is NaN.
inline Mask8 straddles_zero(F32x8 lowest, F32x8 highest) {
  const __m256 zero = _mm256_setzero_ps();
  return {static_cast<unsigned>(_mm256_movemask_ps(
      _mm256_and_ps(_mm256_cmp_ps(lowest.v, zero, _CMP_LT_OQ), _mm256_cmp_ps(highest.v, zero, _CMP_GT_OQ))))};
}

/// Eight slots in 0..7.
struct Slots8 {
  __m256i v;
};
inline Slots8 load_slots(const std::uint8_t* p) {
  return {_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)))};
}
/// out[i] = a[slots[i]]
inline F32x8 permute(F32x8 a, Slots8 slots) {
  return {_mm256_permutevar8x32_ps(a.v, slots.v)};
}

}  // namespace
}  // namespace stbvh
