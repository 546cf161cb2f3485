#include "builder/merged_bounds.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "builder/tightest_bounds.h"
#include "layout/layout.h"

namespace stbvh {

LinearBounds merged_bounds(const ClosedTimeRange& range, std::span<const TimedBounds> children) {
  const auto lives_always = [&](const TimedBounds& child) { return child.range == range; };
  if (std::ranges::all_of(children, lives_always)) {
    LinearBounds all = LinearBounds::empty();
    for (const TimedBounds& child : children) all.extend(child.bounds);
    return all;
  }
  const double length = static_cast<double>(range.last) - range.begin;
  const auto parameter = [&](float time) {
    return length > 0 ? static_cast<float>((static_cast<double>(time) - range.begin) / length) : 0.0f;
  };
  std::array<BoundsSample, 2 * kWidth + 2> samples;
  std::size_t count = 0;
  for (const TimedBounds& child : children) {
    samples[count++] = {parameter(child.range.begin), child.bounds.begin};
    samples[count++] = {parameter(child.range.last), child.bounds.end};
  }
  const auto earlier = [](const BoundsSample& a, const BoundsSample& b) { return a.parameter < b.parameter; };
  std::sort(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count), earlier);
  // Nothing is alive before the first and after the last: those boxes may stand at the ends as well.
  samples[count] = samples[count - 1];
  samples[count++].parameter = 1.0f;
  samples[count] = samples[0];
  samples[count++].parameter = 0.0f;
  std::rotate(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count) - 1,
              samples.begin() + static_cast<std::ptrdiff_t>(count));
  // Halves meet within a float of time: no line should be laid through two boxes so close.
  const auto unite_if_close = [&](std::size_t i) {
    if (samples[i + 1].parameter - samples[i].parameter > 1e-3f) return;
    samples[i].box = samples[i + 1].box = united(samples[i].box, samples[i + 1].box);
  };
  for (std::size_t i = 0; i + 1 < count; ++i) unite_if_close(i);
  for (std::size_t i = count - 1; i-- > 0;) unite_if_close(i);
  return tightest_at_centre(std::span(samples).first(count));
}

}  // namespace stbvh
