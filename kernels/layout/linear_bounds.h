/// Linear bounds: a box at each end of a time range (Woop et al. 2017, section 3.1).
#pragma once

#include <cstddef>
#include <cstring>

#include "simd/box4.h"

namespace stbvh {

/// Boxes at the two ends of a time range; interpolated to any time inside it they contain the geometry.
struct LinearBounds {
  Box4 begin, end;

  static LinearBounds empty() { return {Box4::empty(), Box4::empty()}; }

  /// Twice the lower and the upper corner at the centre of the time range.
  F32x4 twice_centre_lower() const { return begin.lower + end.lower; }
  F32x4 twice_centre_upper() const { return begin.upper + end.upper; }
  /// SA' of the MBSAH up to a constant factor: four times half the surface area at the centre; 0 if empty.
  float centre_area() const {
    return half_area(max(twice_centre_upper() - twice_centre_lower(), F32x4(0.0f)));
  }
  /// Four times the centroid at the centre.
  F32x4 centroid4() const { return twice_centre_lower() + twice_centre_upper(); }

  void extend(const LinearBounds& other) {
    begin.extend(other.begin);
    end.extend(other.end);
  }
  /// At all times.
  Box4 whole() const { return united(begin, end); }
  bool is_static() const { return equal3(begin.lower, end.lower) && equal3(begin.upper, end.upper); }
};

/// Linear bounds without the lanes that carry nothing.
class PackedBounds {
 public:
  PackedBounds() = default;
  explicit PackedBounds(const LinearBounds& bounds) {
    const F32x4* corners[] = {&bounds.begin.lower, &bounds.begin.upper, &bounds.end.lower, &bounds.end.upper};
    for (std::size_t i = 0; i < 4; ++i) std::memcpy(corners_[i], corners[i], sizeof corners_[i]);
  }
  LinearBounds unpacked() const {
    const auto corner = [&](std::size_t i) { return F32x4(corners_[i][0], corners_[i][1], corners_[i][2]); };
    return {{corner(0), corner(1)}, {corner(2), corner(3)}};
  }

 private:
  float corners_[4][3];
};

}  // namespace stbvh
