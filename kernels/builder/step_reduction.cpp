#include "builder/step_reduction.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "layout/time_grid.h"

namespace stbvh {

namespace {

constexpr std::size_t kChunk = 1024;

/// Tells how far a mesh is from what some of its steps say of the others.
class Chords {
 public:
  Chords(const MeshView& mesh, const VertexChoice& vertices, float tolerance)
      : mesh_(mesh), vertices_(vertices), tolerance_(tolerance) {
    for (std::size_t step = 0; step < mesh.steps.size(); ++step) times_.push_back(step_time(mesh, step));
  }

  double time(std::size_t step) const { return times_[step]; }

  /// Whether the steps between `first` and `last` may be left out; `deviation` grows to that of doing so.
  bool may_replace(std::size_t first, std::size_t last, double& deviation) const {
    return within(last - first, deviation, [&](std::size_t vertex, std::size_t i) {
      return difference(vertex, first, last, first + i);
    });
  }

  /// Whether `vertex` is at `step` where `first` and `last` say, or `first` alone where they are the same.
  bool is_said(std::size_t vertex, std::size_t first, std::size_t last, std::size_t step) const {
    return is_small(difference(vertex, first, last, step));
  }

  /// Whether all steps but the first may be left out.
  bool stands_still(double& deviation) const {
    return within(mesh_.steps.size(), deviation,
                  [&](std::size_t vertex, std::size_t step) { return difference(vertex, 0, 0, step); });
  }

 private:
  struct Difference {
    double squared = 0.0;
    bool is_rounding = true;
  };

  bool is_small(const Difference& d) const {
    return d.is_rounding || d.squared <= static_cast<double>(tolerance_) * tolerance_;
  }

  /// Of `vertex` at `step` from the line between two others, or from one.
  Difference difference(std::size_t vertex, std::size_t first, std::size_t last, std::size_t step) const {
    const Vec3f begin = mesh_.steps[first].position(vertex), end = mesh_.steps[last].position(vertex);
    const Vec3f given = mesh_.steps[step].position(vertex);
    const double along =
        first == last ? 0.0 : (times_[step] - times_[first]) / (times_[last] - times_[first]);
    Difference result;
    const auto add = [&](double a, double b, double p) {
      const double off = std::fabs(p - ((1.0 - along) * a + along * b));
      result.squared += off * off;
      const double sizes = std::fabs(p) + (1.0 - along) * std::fabs(a) + along * std::fabs(b);
      result.is_rounding &= off <= 0x1p-24 * sizes;
    };
    add(begin.x, end.x, given.x);
    add(begin.y, end.y, given.y);
    add(begin.z, end.z, given.z);
    return result;
  }

  /// Whether `difference_of(vertex, i)` is small enough for all chosen vertices and 0 < i < `count`.
  template <typename DifferenceOf>
  bool within(std::size_t count, double& deviation, const DifferenceOf& difference_of) const {
    std::atomic<bool> fits{true};
    const tbb::blocked_range<std::size_t> all(0, vertices_.count, kChunk);
    const auto largest_in = [&](const tbb::blocked_range<std::size_t>& chunk, double squared) {
      for (std::size_t v = chunk.begin(); v != chunk.end() && fits.load(std::memory_order_relaxed); ++v) {
        const std::uint32_t vertex = vertices_.vertex(v);
        if (vertex == kNoVertex) continue;
        for (std::size_t i = 1; i < count; ++i) {
          const Difference d = difference_of(vertex, i);
          if (!is_small(d)) {
            fits.store(false, std::memory_order_relaxed);
            return squared;
          }
          squared = std::max(squared, d.squared);
        }
      }
      return squared;
    };
    const double largest =
        all.is_divisible()
            ? tbb::parallel_reduce(all, 0.0, largest_in, [](double a, double b) { return std::max(a, b); })
            : largest_in(all, 0.0);
    if (!fits.load()) return false;
    deviation = std::max(deviation, std::sqrt(largest));
    return true;
  }

  const MeshView& mesh_;
  const VertexChoice& vertices_;
  float tolerance_;
  std::vector<double> times_;
};

/// The last of `steps` that may follow the one at `first`, all between them left out.
std::size_t longest_from(const Chords& chords, std::span<const std::size_t> steps, std::size_t first,
                         double& deviation) {
  const std::size_t last = steps.size() - 1;
  std::size_t fits = first + 1, reach = 1;
  double fitting = 0.0;
  // It may: what is asked for is how far off that is.
  if (steps[fits] > steps[first] + 1) chords.may_replace(steps[first], steps[fits], fitting);
  const auto try_step = [&](std::size_t i) {
    double off = 0.0;
    if (!chords.may_replace(steps[first], steps[i], off)) return false;
    fits = i;
    fitting = off;
    return true;
  };
  while (fits < last && try_step(std::min(fits + reach, last))) reach *= 2;
  std::size_t too_far = std::min(fits + reach, last);
  while (too_far > fits + 1) {
    const std::size_t middle = fits + (too_far - fits) / 2;
    if (!try_step(middle)) too_far = middle;
  }
  deviation = std::max(deviation, fitting);
  return fits;
}

}  // namespace

float step_time(const MeshView& mesh, std::size_t step) {
  if (!mesh.step_times.empty()) return normal_time(mesh.step_times[step]);
  const double begin = mesh.time_range.begin, end = mesh.time_range.end;
  if (step == mesh.steps.size() - 1) return normal_time(mesh.time_range.end);  // whatever rounds below
  const auto segments = static_cast<double>(mesh.steps.size() - 1);
  return normal_time(static_cast<float>(begin + (end - begin) * (static_cast<double>(step) / segments)));
}

StepReduction reduce_steps(const MeshView& mesh, const VertexChoice& vertices,
                           std::span<const std::size_t> steps, float tolerance) {
  const Chords chords(mesh, vertices, tolerance);
  StepReduction reduction;
  if (chords.time(steps.front()) <= 0.0 && chords.time(steps.back()) >= 1.0 &&
      chords.stands_still(reduction.deviation)) {
    reduction.kept = {0};
    return reduction;
  }
  reduction.kept = {steps.front()};
  if (chords.may_replace(steps.front(), steps.back(), reduction.deviation)) {
    reduction.kept.push_back(steps.back());
    return reduction;
  }
  for (std::size_t i = 0; i + 1 < steps.size();) {
    i = longest_from(chords, steps, i, reduction.deviation);
    reduction.kept.push_back(steps[i]);
  }
  // Equidistant times may be nearer to each other than floats are.
  for (std::size_t i = 1; i < reduction.kept.size(); ++i) {
    if (is_usable({step_time(mesh, reduction.kept[i - 1]), step_time(mesh, reduction.kept[i])})) continue;
    reduction.kept.assign(steps.begin(), steps.end());
    reduction.deviation = 0.0;
    break;
  }
  return reduction;
}

double dispensable_share(const MeshView& mesh, const VertexChoice& vertices,
                         std::span<const std::size_t> steps, float tolerance) {
  const Chords chords(mesh, vertices, tolerance);
  std::size_t dispensable = 0, all = 0;
  for (std::size_t v = 0; v < vertices.count; ++v) {
    const std::uint32_t vertex = vertices.vertex(v);
    if (vertex == kNoVertex) continue;
    all += steps.size() - 1;
    // Of the first and the last, one: where the vertex stands still.
    dispensable += chords.is_said(vertex, steps.front(), steps.front(), steps.back());
    for (std::size_t i = 1; i + 1 < steps.size(); ++i)
      dispensable += chords.is_said(vertex, steps[i - 1], steps[i + 1], steps[i]);
  }
  return all == 0 ? 0.0 : static_cast<double>(dispensable) / static_cast<double>(all);
}

}  // namespace stbvh
