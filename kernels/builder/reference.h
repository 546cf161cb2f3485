/// A reference: a meshlet together with the time range in which a subtree holds it.
#pragma once

#include <cstdint>

#include "layout/linear_bounds.h"

namespace stbvh {

/// Linear bounds over the time range of the set that holds the reference (not stored), and whose they are:
/// the fourth lanes of the corners at its begin carry the ids.
struct Reference {
  float lower_begin[3];
  std::uint32_t meshlet;
  float upper_begin[3];
  std::uint32_t mesh;
  float lower_end[4];
  float upper_end[4];

  LinearBounds bounds() const {
    // The ids must not be taken for floats: as such they are denormal, and slow on some processors.
    const __m128 xyz = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
    return {{_mm_and_ps(_mm_loadu_ps(lower_begin), xyz), _mm_and_ps(_mm_loadu_ps(upper_begin), xyz)},
            {_mm_loadu_ps(lower_end), _mm_loadu_ps(upper_end)}};
  }
};
static_assert(sizeof(Reference) == 64);

inline Reference make_reference(const LinearBounds& bounds, std::uint32_t mesh, std::uint32_t meshlet) {
  Reference r;
  _mm_storeu_ps(r.lower_begin, bounds.begin.lower.v);
  _mm_storeu_ps(r.upper_begin, bounds.begin.upper.v);
  _mm_storeu_ps(r.lower_end, bounds.end.lower.v);
  _mm_storeu_ps(r.upper_end, bounds.end.upper.v);
  r.meshlet = meshlet;
  r.mesh = mesh;
  return r;
}

}  // namespace stbvh
