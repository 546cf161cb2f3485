/// What a traversal precomputes for a ray.
#pragma once

#include <xmmintrin.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "layout/layout.h"
#include "simd/f32x8.h"
#include "stbvh/structure.h"

namespace stbvh {
namespace {

/// Where a node keeps its near and far planes of each axis for rays of one octant: bytes from its start.
struct PlaneOffsets {
  std::uint32_t near[3], far[3];
};

constexpr PlaneOffsets plane_offsets(unsigned negative) {
  constexpr auto kPlaneBytes = static_cast<std::uint32_t>(kWidth * sizeof(float));
  PlaneOffsets offsets{};
  for (unsigned i = 0; i < 3; ++i) {
    const bool reversed = (negative >> i & 1u) != 0;
    offsets.near[i] = kPlaneBytes * (reversed ? kUpperX + i : kLowerX + i);
    offsets.far[i] = kPlaneBytes * (reversed ? kLowerX + i : kUpperX + i);
  }
  return offsets;
}

/// By the signs of the direction: bit i is set where component i is negative.
constexpr PlaneOffsets kPlaneOffsets[] = {plane_offsets(0), plane_offsets(1), plane_offsets(2),
                                          plane_offsets(3), plane_offsets(4), plane_offsets(5),
                                          plane_offsets(6), plane_offsets(7)};

/// Directions are divided by their largest component, so that neither their length nor a vanishing component
/// overflows: boxes are met at s = t * |direction[kz]|.
struct TraversalRay {
  /// What Test::slab() takes for near planes, and for far ones. The fourth of each is not used.
  alignas(16) float near_origin[4];
  alignas(16) float far_origin[4];
  alignas(16) float inverse[4];  ///< 1 / (direction[i] / |direction[kz]|), finite
  const PlaneOffsets* planes;    ///< which planes are near, and which far
  alignas(16) float origin[4];   ///< x, y, z; the fourth of both is not used
  alignas(16) float direction[4];
  int kx, ky, kz;  ///< kz: the axis of the largest direction component (Woop, Benthin, Wald 2013)
  float shear_x, shear_y;
  double direction_z;  ///< direction[kz]
  float time;
  float tnear, tfar;    ///< of the query, tfar that of the closest hit so far
  float s_near, s_far;  ///< the same for boxes
  float s_scale;        ///< |direction[kz]|
  float s_slack;        ///< how far on the t of a hit may be a denormal number, or flushed to zero
  float sign_z;         ///< of direction[kz]
  /// Of any hit: what lies this far along the ray, on the axis kz, is hit within the range for certain.
  float certain_near, certain_far;
  std::uint32_t mask;
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();
/// Moved outwards an origin must stay finite: where it did not, empty slots of nodes would be met.
constexpr float kFarthestOrigin = 0x1p126f;

inline bool is_finite(float x) {
  return std::fabs(x) <= kLargest;
}

inline void update_s_far(TraversalRay& r) {
  r.s_far = r.tfar * r.s_scale * (1.0f + 0x1p-21f) + r.s_slack;
}

/// x, y, z, and a lane that carries nothing. A ray's set-up is a third of the time of the cheapest rays.
using Axes = __m128;

/// Largest of x, y, z, in these three lanes.
inline Axes largest_of(Axes a) {
  const Axes yzx = _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 0, 2, 1));
  const Axes zxy = _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 1, 0, 2));
  return _mm_max_ps(_mm_max_ps(a, yzx), zxy);
}

inline unsigned bits_of(Axes mask) {
  return static_cast<unsigned>(_mm_movemask_ps(mask)) & 7u;
}

/// Largest distance along an axis from the ray's origin to anything in the scene.
inline Axes largest_distance(const StructureView& structure, Axes origin) {
  const Axes sign = _mm_set1_ps(-0.0f);
  const Axes to_lower = _mm_andnot_ps(sign, _mm_sub_ps(_mm_load_ps(structure.lower), origin));
  const Axes to_upper = _mm_andnot_ps(sign, _mm_sub_ps(_mm_load_ps(structure.upper), origin));
  return largest_of(_mm_max_ps(to_lower, to_upper));
}

/// Nothing is certain where edge functions, products of twice the distance, could overflow or lose precision.
inline void set_certain_range(TraversalRay& r, float distance) {
  constexpr float kLeast = 0x1p-80f;  // its products stay normal numbers: others are slow
  const float near = std::fabs(r.tnear) > kLeast ? std::fabs(r.tnear) : kLeast;
  const float s = near * r.s_scale * (1.0f + 0x1p-20f);
  r.certain_near = s > kLeast ? s : kLeast;
  const float far = r.tfar < kLargest ? r.tfar : kLargest;
  r.certain_far = distance < 1e18f ? far * r.s_scale * (1.0f - 0x1p-20f) : 0.0f;
  r.sign_z = std::copysign(1.0f, static_cast<float>(r.direction_z));
}

// Four floats are read from the start of each vector: the one behind it carries nothing, but must be the
// ray's.
static_assert(offsetof(Ray, tnear) == offsetof(Ray, origin) + sizeof(Vec3f) &&
              offsetof(Ray, time) == offsetof(Ray, direction) + sizeof(Vec3f));

/// False for a ray that hits nothing: not finite, of zero direction, or at a time outside the structure's.
template <typename Test>
inline bool setup_ray(const StructureView& structure, const Ray& ray, TraversalRay& r) {
  // The fourth lanes hold what follows in the ray.
  const Axes origin = _mm_loadu_ps(&ray.origin.x);
  const Axes direction = _mm_loadu_ps(&ray.direction.x);
  const Axes sign_bit = _mm_set1_ps(-0.0f);
  const Axes size = _mm_andnot_ps(sign_bit, direction);
  // Also false where something is not a number.
  const Axes origin_is_near = _mm_cmple_ps(_mm_andnot_ps(sign_bit, origin), _mm_set1_ps(kFarthestOrigin));
  const Axes direction_is_finite = _mm_cmple_ps(size, _mm_set1_ps(kLargest));
  if (bits_of(_mm_and_ps(origin_is_near, direction_is_finite)) != 7) return false;
  if (!(ray.time >= structure.time_begin && ray.time <= structure.time_last)) return false;
  if (!(ray.tnear <= ray.tfar)) return false;  // also where either is NaN

  const Axes largest = largest_of(size);
  const float scale = _mm_cvtss_f32(largest);
  if (!(scale > 0.0f)) return false;
  // The last of the largest, without branches, which random directions would mispredict.
  const unsigned largest_bits = bits_of(_mm_cmpeq_ps(size, largest));
  r.kz = static_cast<int>((0x22221100u >> (4 * largest_bits)) & 3u);
  r.kx = (0x021 >> (4 * r.kz)) & 3;
  r.ky = (0x102 >> (4 * r.kz)) & 3;
  alignas(16) float d[4];
  _mm_store_ps(d, direction);
  r.direction_z = d[r.kz];
  r.shear_x = d[r.kx] / d[r.kz];
  r.shear_y = d[r.ky] / d[r.kz];

  // A power of two keeps ratios of tiny directions from underflowing.
  const float unit = scale < 0x1p-40f ? 0x1p80f : 1.0f;
  // Keeps the inverse finite: the slack covers the ray's deviation.
  const float least = scale * unit * 1e-18f;
  const Axes sign = _mm_and_ps(sign_bit, direction);
  const Axes magnitude = _mm_max_ps(_mm_mul_ps(size, _mm_set1_ps(unit)), _mm_set1_ps(least));
  const Axes inverse = _mm_or_ps(sign, _mm_div_ps(_mm_set1_ps(unit * scale), magnitude));
  const Axes distance = largest_distance(structure, origin);
  Test::set_slabs(origin, direction, inverse, distance, r);
  r.planes = &kPlaneOffsets[bits_of(direction)];
  _mm_store_ps(r.origin, origin);
  _mm_store_ps(r.direction, direction);
  r.time = ray.time;
  r.mask = ray.mask;
  r.tnear = ray.tnear;
  r.tfar = ray.tfar;
  r.s_scale = scale;
  r.s_slack = std::numeric_limits<float>::min() * (scale > 1.0f ? scale : 1.0f);
  r.s_near = ray.tnear * scale * (1.0f - 0x1p-21f) - r.s_slack;
  if (ray.tnear < 0.0f) r.s_near = ray.tnear * scale * (1.0f + 0x1p-21f) - r.s_slack;
  update_s_far(r);
  set_certain_range(r, _mm_cvtss_f32(distance));
  return true;
}

}  // namespace
}  // namespace stbvh
