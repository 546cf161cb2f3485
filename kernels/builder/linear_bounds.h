/// Linear bounds: a box at each end of a time range (ALGORITHM section 4; Woop et al. 2017, section 3.1).
#pragma once

#include <cstddef>
#include <cstring>
#include <span>

#include "simd/f32x4.h"

namespace stbvh {

/// Boxes at the two ends of a time range; interpolated to any time inside it they contain the geometry.
struct LinearBounds {
  F32x4 lower_begin, upper_begin;
  F32x4 lower_end, upper_end;

  static LinearBounds empty();

  /// Twice the lower and the upper corner at the centre of the time range.
  F32x4 twice_centre_lower() const { return lower_begin + lower_end; }
  F32x4 twice_centre_upper() const { return upper_begin + upper_end; }
  /// SA' of the MBSAH up to a constant factor: four times half the surface area at the centre; 0 if empty.
  float centre_area() const;
  /// Four times the centroid at the centre.
  F32x4 centroid4() const { return twice_centre_lower() + twice_centre_upper(); }

  void extend(const LinearBounds& other);
  bool is_static() const { return equal3(lower_begin, lower_end) && equal3(upper_begin, upper_end); }
};

inline LinearBounds LinearBounds::empty() {
  const F32x4 inf(std::numeric_limits<float>::infinity());
  const F32x4 minus_inf(-std::numeric_limits<float>::infinity());
  return {inf, minus_inf, inf, minus_inf};
}

inline void LinearBounds::extend(const LinearBounds& other) {
  lower_begin = min(lower_begin, other.lower_begin);
  upper_begin = max(upper_begin, other.upper_begin);
  lower_end = min(lower_end, other.lower_end);
  upper_end = max(upper_end, other.upper_end);
}

inline float LinearBounds::centre_area() const {
  const F32x4 size = twice_centre_upper() - twice_centre_lower();
  return half_area(max(size, F32x4(0.0f)));
}

/// Linear bounds without the lanes that carry nothing.
class PackedBounds {
 public:
  PackedBounds() = default;
  explicit PackedBounds(const LinearBounds& bounds);
  LinearBounds unpacked() const;

 private:
  float corners_[4][3];
};

inline PackedBounds::PackedBounds(const LinearBounds& bounds) {
  const F32x4* corners[] = {&bounds.lower_begin, &bounds.upper_begin, &bounds.lower_end, &bounds.upper_end};
  for (std::size_t i = 0; i < 4; ++i) std::memcpy(corners_[i], corners[i], sizeof corners_[i]);
}

inline LinearBounds PackedBounds::unpacked() const {
  const auto corner = [&](std::size_t i) { return F32x4(corners_[i][0], corners_[i][1], corners_[i][2]); };
  return {corner(0), corner(1), corner(2), corner(3)};
}

/// Box of the geometry at one time, as a parameter in [0, 1] of the time range.
struct BoundsSample {
  float parameter;
  F32x4 lower, upper;
};

/// For each face the line outside all samples that is tightest at the centre: the edge of their convex hull
/// that spans the centre. Optimal for SA'. Samples ascend in parameter, from 0 to 1.
/// More than two are rounded outwards, for the rounding of parameters and lines.
LinearBounds tightest_at_centre(std::span<const BoundsSample> samples);

}  // namespace stbvh
