#include "builder/tightest_bounds.h"

#include <algorithm>
#include <cmath>

#include "builder/sample_array.h"

namespace stbvh {

namespace {

struct Point {
  double s, v;
};

/// The lower hull edge over `centre`, as values at 0 and 1 (Andrew's monotone chain).
Point lower_hull_line(std::span<const Point> points, double centre) {
  SampleArray<Point> hull(points.size());
  std::size_t n = 0;
  for (Point p : points) {
    if (n > 0 && p.s <= hull[n - 1].s) {  // two samples at one time: the lower one counts
      if (hull[n - 1].v <= p.v) continue;
      p.s = hull[--n].s;
    }
    while (n >= 2) {
      const Point& a = hull[n - 2];
      const Point& b = hull[n - 1];
      if ((b.s - a.s) * (p.v - a.v) > (b.v - a.v) * (p.s - a.s)) break;
      --n;
    }
    hull[n++] = p;
  }
  std::size_t i = 1;
  while (i + 1 < n && hull[i].s < centre) ++i;
  const Point& a = hull[i - 1];
  const Point& b = hull[i];
  const double slope = (b.v - a.v) / (b.s - a.s);
  return {a.v - a.s * slope, a.v + (1.0 - a.s) * slope};
}

}  // namespace

LinearBounds tightest_at_centre(std::span<const BoundsSample> samples) {
  const BoundsSample& first = samples.front();
  const BoundsSample& last = samples.back();
  if (samples.size() <= 2) return {first.box, last.box};
  struct Corners {
    alignas(16) float lower_upper[2][4];
  };
  SampleArray<Corners> corners(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    _mm_store_ps(corners[i].lower_upper[0], samples[i].box.lower.v);
    _mm_store_ps(corners[i].lower_upper[1], samples[i].box.upper.v);
  }
  SampleArray<Point> points(samples.size());
  alignas(16) float lines[4][4] = {};
  for (int axis = 0; axis < 3; ++axis) {
    for (int upper = 0; upper < 2; ++upper) {
      const double sign = upper ? -1.0 : 1.0;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const float face = corners[i].lower_upper[upper][axis];
        points[i] = {samples[i].parameter, sign * static_cast<double>(face)};
      }
      const Point line = lower_hull_line({points.data(), samples.size()}, 0.5);
      // Parameters and the line's two values are rounded to float: outwards by more than that.
      const double outwards = -sign * 0x1p-22 * std::max(std::fabs(line.s), std::fabs(line.v));
      lines[upper][axis] = static_cast<float>(sign * line.s + outwards);
      lines[2 + upper][axis] = static_cast<float>(sign * line.v + outwards);
    }
  }
  const auto line = [&](int i) { return F32x4(_mm_load_ps(lines[i])); };
  return {{line(0), line(1)}, {line(2), line(3)}};
}

}  // namespace stbvh
