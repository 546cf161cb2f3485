/// Which segment a time belongs to: defined here by one float evaluation, and nowhere else.
#pragma once

#include <cstdint>
#include <limits>

namespace stbvh {

/// Steps of a mesh in global ray time: equidistant over [begin, end].
struct TimeGrid {
  float begin;
  float end;
  float length;    ///< end - begin, rounded once
  float segments;  ///< number of segments as a float; 0: static
};

/// A denormal time counts as 0: with flush-to-zero it does in any comparison, on the threads that have it
/// set.
static inline float normal_time(float time) {
  constexpr float kLeast = std::numeric_limits<float>::min();
  return time > -kLeast && time < kLeast ? 0.0f : time;
}

struct SegmentTime {
  std::uint32_t segment;
  float fraction;  ///< of the segment, in [0, 1]
};

/// u = (t - begin) / length * segments; segment min(floor(u), S - 1). Every operation is monotone in t, so
/// the segments met over a closed range of times are those between its ends. `time` lies in [begin, end], S >
/// 0. Internal linkage on purpose: this is compiled for several instruction sets (one definition rule).
static inline SegmentTime segment_at(const TimeGrid& grid, float time) {
  const float u = (time - grid.begin) / grid.length * grid.segments;
  const int last = static_cast<int>(grid.segments) - 1;
  const int floor_u = static_cast<int>(u);
  const int segment = floor_u < last ? floor_u : last;
  return {static_cast<std::uint32_t>(segment), u - static_cast<float>(segment)};
}

}  // namespace stbvh
