/// Which segment a time belongs to: defined here by one float evaluation, and nowhere else.
#pragma once

#include <cstdint>
#include <limits>

namespace stbvh {

/// Steps of a mesh in global ray time: equidistant over [begin, end], or at times of their own.
struct TimeGrid {
  float begin;
  float end;
  float length;    ///< end - begin, rounded once
  float segments;  ///< number of segments as a float; 0: static; negative: their times stand elsewhere

  bool is_static() const { return segments == 0.0f; }
  bool is_uneven() const { return segments < 0.0f; }
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

/// The same among steps with `times` of their own: segment k begins at times[k] and ends before times[k + 1],
/// the last one at it. `first` is a segment that has begun at `time`, `last` the mesh's last; from `first` on
/// ever longer steps are tried, as a leaf seldom holds more than a few. f = (t - t_k) / (t_{k+1} - t_k), of
/// which two operations are rounded where t is near t_k, three at most.
static inline SegmentTime segment_among(const float* times, std::uint32_t first, std::uint32_t last,
                                        float time) {
  std::uint32_t begun = first, reach = 1;
  while (begun + reach <= last && times[begun + reach] <= time) {
    begun += reach;
    reach *= 2;
  }
  std::uint32_t not_begun = begun + reach <= last ? begun + reach : last + 1;
  while (not_begun - begun > 1) {
    const std::uint32_t middle = begun + (not_begun - begun) / 2;
    if (times[middle] <= time) {
      begun = middle;
    } else {
      not_begun = middle;
    }
  }
  return {begun, (time - times[begun]) / (times[begun + 1] - times[begun])};
}

}  // namespace stbvh
