/// How rays are tested against the planes of boxes.
#pragma once

#include "traverse/ray_setup.inl"

namespace stbvh {
namespace {

/// No box hides what the watertight triangle test accepts.
struct PaddedSlabs {
  /// How far the triangle test may see a vertex from where it is: its translation, interpolation and shear
  /// round by up to 8 * 2^-24 of the distance of the vertex, the slab distances by 3 more (docs/accuracy.md).
  /// The second term survives the rounding of the sum with the origin, the third holds where denormal numbers
  /// are rounded, or flushed to zero.
  static Axes slack(Axes origin, Axes distance) {
    const Axes size = _mm_andnot_ps(_mm_set1_ps(-0.0f), origin);
    const Axes relative =
        _mm_add_ps(_mm_mul_ps(_mm_set1_ps(0x1p-20f), distance), _mm_mul_ps(_mm_set1_ps(0x1p-22f), size));
    return _mm_max_ps(relative, _mm_set1_ps(std::numeric_limits<float>::min()));
  }

  /// The near planes move towards the ray's origin by the slack, the far planes away from it.
  static void set_slabs(Axes origin, Axes direction, Axes inverse, Axes distance, TraversalRay& r) {
    const Axes sign = _mm_and_ps(_mm_set1_ps(-0.0f), direction);
    const Axes backwards = _mm_or_ps(sign, slack(origin, distance));
    _mm_store_ps(r.inverse, inverse);
    _mm_store_ps(r.near_origin, _mm_add_ps(origin, backwards));
    _mm_store_ps(r.far_origin, _mm_sub_ps(origin, backwards));
  }

  static F32x8 slab(F32x8 plane, F32x8 origin, F32x8 inverse) { return (plane - origin) * inverse; }
};

/// As renderers commonly do it.
struct UnpaddedSlabs {
  static void set_slabs(Axes origin, Axes, Axes inverse, Axes, TraversalRay& r) {
    _mm_store_ps(r.inverse, inverse);
    // Finite: where it were not, empty slots of nodes would be met.
    const Axes shift = _mm_mul_ps(_mm_xor_ps(_mm_set1_ps(-0.0f), origin), inverse);
    const Axes most = _mm_set1_ps(kLargest);
    const Axes finite = _mm_max_ps(_mm_min_ps(shift, most), _mm_set1_ps(-kLargest));
    _mm_store_ps(r.near_origin, finite);
    _mm_store_ps(r.far_origin, finite);
  }

  static F32x8 slab(F32x8 plane, F32x8 shift, F32x8 inverse) { return multiply_add(plane, inverse, shift); }
};

}  // namespace
}  // namespace stbvh
