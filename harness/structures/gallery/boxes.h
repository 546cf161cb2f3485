/// What methods ask of boxes.
#pragma once

#include "simd/box4.h"

namespace stbvh::harness::gallery {

/// Axes in which the lower face is above the upper one.
inline unsigned inverted_axes(const Box4& box) {
  return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpgt_ps(box.lower.v, box.upper.v))) & 7u;
}

/// Whether neither lies beyond the other in any axis.
inline bool overlap(const Box4& a, const Box4& b) {
  const __m128 apart = _mm_or_ps(_mm_cmplt_ps(a.upper.v, b.lower.v), _mm_cmplt_ps(b.upper.v, a.lower.v));
  return (_mm_movemask_ps(apart) & 7) == 0;
}

}  // namespace stbvh::harness::gallery
