/// The times of a subtree.
#pragma once

#include <array>
#include <cmath>
#include <limits>

namespace stbvh {

/// Closed range of float times; the next range begins at the next float.
struct ClosedTimeRange {
  float begin;
  float last;

  float length() const { return last - begin; }
  bool operator==(const ClosedTimeRange&) const = default;
};

/// The times before `boundary`, and those from it on.
inline std::array<ClosedTimeRange, 2> halves_at(const ClosedTimeRange& range, float boundary) {
  return {{{range.begin, std::nextafter(boundary, -std::numeric_limits<float>::infinity())},
           {boundary, range.last}}};
}

}  // namespace stbvh
