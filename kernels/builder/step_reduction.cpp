#include "builder/step_reduction.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

#include "layout/time_grid.h"

namespace stbvh {

namespace {

/// Vertices that are looked at step by step: one by one, each would be read in thousands of buffers.
constexpr std::size_t kBlock = 64;
constexpr std::size_t kBlocksAtOnce = 16;  ///< of one thread, at least
constexpr std::size_t kSampledVertices = 256;
/// How often a mesh's sample may be wrong: finding that out costs as much as all that is left out.
constexpr std::size_t kMostWrongGuesses = 16;

/// Tells how far a mesh is from what some of its steps say of the others.
class Chords {
 public:
  Chords(const MeshView& mesh, const VertexChoice& vertices, float tolerance)
      : mesh_(mesh), vertices_(vertices), tolerance_(tolerance) {
    for (std::size_t step = 0; step < mesh.steps.size(); ++step) times_.push_back(step_time(mesh, step));
    const std::size_t sampled = std::min(kSampledVertices, vertices.count);
    for (std::size_t i = 0; i < sampled; ++i) {
      const std::uint32_t vertex = vertices.vertex(i * vertices.count / sampled);
      if (vertex != kNoVertex) sample_.push_back(vertex);
    }
  }

  double time(std::size_t step) const { return times_[step]; }

  /// Whether the steps between `first` and `last` may be left out; `deviation` grows to that of doing so.
  bool may_replace(std::size_t first, std::size_t last, double& deviation) const {
    return within({first, last, first + 1, last}, deviation) == kNoVertex;
  }

  /// Whether a sample of the vertices may be asked first.
  bool may_guess() const { return wrong_guesses_ < kMostWrongGuesses; }

  /// The same as may_replace() as far as the sample tells.
  bool seems_replaceable(std::size_t first, std::size_t last) const {
    double squared = 0.0;
    for (std::size_t i = 0; i < sample_.size(); i += kBlock) {
      const std::size_t count = std::min(kBlock, sample_.size() - i);
      const std::span block = std::span(sample_).subspan(i, count);
      if (first_beyond(block, {first, last, first + 1, last}, squared) != kNoVertex) return false;
    }
    return true;
  }

  /// may_replace() where the sample has said so: the sample learns where it was wrong.
  bool confirms(std::size_t first, std::size_t last, double& deviation) {
    const std::uint32_t beyond = within({first, last, first + 1, last}, deviation);
    if (beyond == kNoVertex) return true;
    sample_.push_back(beyond);
    ++wrong_guesses_;
    return false;
  }

  /// Whether `vertex` is at `step` where `first` and `last` say, or `first` alone where they are the same.
  bool is_said(std::uint32_t vertex, std::size_t first, std::size_t last, std::size_t step) const {
    return is_small(difference(vertex, first, last, step, along(first, last, step)));
  }

  /// Whether all steps but the first may be left out.
  bool stands_still(double& deviation) const {
    return within({0, 0, 1, mesh_.steps.size()}, deviation) == kNoVertex;
  }

 private:
  struct Difference {
    double squared = 0.0;
    bool is_rounding = true;
  };
  /// What `first` and `last` say of the steps from `begin` to before `end`.
  struct Stretch {
    std::size_t first, last, begin, end;
  };

  bool is_small(const Difference& d) const {
    return d.is_rounding || d.squared <= static_cast<double>(tolerance_) * tolerance_;
  }

  double along(std::size_t first, std::size_t last, std::size_t step) const {
    return first == last ? 0.0 : (times_[step] - times_[first]) / (times_[last] - times_[first]);
  }

  /// Of `vertex` at `step` from the line between two others, or from one.
  Difference difference(std::uint32_t vertex, std::size_t first, std::size_t last, std::size_t step,
                        double along) const {
    const Vec3f begin = mesh_.steps[first].position(vertex), end = mesh_.steps[last].position(vertex);
    const Vec3f given = mesh_.steps[step].position(vertex);
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

  /// One of `vertices` that is not where the stretch says, or kNoVertex; `squared` grows to the largest
  /// difference.
  std::uint32_t first_beyond(std::span<const std::uint32_t> vertices, const Stretch& stretch,
                             double& squared) const {
    for (std::size_t step = stretch.begin; step < stretch.end; ++step) {
      const double share = along(stretch.first, stretch.last, step);
      for (const std::uint32_t vertex : vertices) {
        const Difference d = difference(vertex, stretch.first, stretch.last, step, share);
        if (!is_small(d)) return vertex;
        squared = std::max(squared, d.squared);
      }
    }
    return kNoVertex;
  }

  std::uint32_t first_beyond_in(std::size_t block, const Stretch& stretch, double& squared) const {
    std::array<std::uint32_t, kBlock> vertices;
    std::size_t count = 0;
    const std::size_t end = std::min((block + 1) * kBlock, vertices_.count);
    for (std::size_t v = block * kBlock; v < end; ++v) {
      vertices[count] = vertices_.vertex(v);
      count += vertices[count] != kNoVertex;
    }
    return first_beyond(std::span(vertices).first(count), stretch, squared);
  }

  /// The same of all that are chosen, in the first block that has one, for any number of threads; where there
  /// is none `deviation` grows to the largest distance.
  std::uint32_t within(const Stretch& stretch, double& deviation) const {
    if (stretch.begin >= stretch.end) return kNoVertex;
    const std::size_t blocks = (vertices_.count + kBlock - 1) / kBlock;
    std::atomic<std::size_t> first_bad{blocks};
    const auto largest_in = [&](const tbb::blocked_range<std::size_t>& range, double squared) {
      for (std::size_t b = range.begin(); b < std::min(range.end(), first_bad.load()); ++b) {
        if (first_beyond_in(b, stretch, squared) == kNoVertex) continue;
        std::size_t bad = first_bad.load();
        while (b < bad && !first_bad.compare_exchange_weak(bad, b)) continue;
      }
      return squared;
    };
    const tbb::blocked_range<std::size_t> all(0, blocks, kBlocksAtOnce);
    double largest =
        all.is_divisible()
            ? tbb::parallel_reduce(all, 0.0, largest_in, [](double a, double b) { return std::max(a, b); })
            : largest_in(all, 0.0);
    if (first_bad.load() < blocks) return first_beyond_in(first_bad.load(), stretch, largest);
    deviation = std::max(deviation, std::sqrt(largest));
    return kNoVertex;
  }

  const MeshView& mesh_;
  const VertexChoice& vertices_;
  float tolerance_;
  std::vector<double> times_;
  std::vector<std::uint32_t> sample_;
  std::size_t wrong_guesses_ = 0;
};

/// The last of those from `fits` to `last` for which `may_reach` says so, by doubling and halving; it does of
/// `fits`.
template <typename MayReach>
std::size_t farthest(std::size_t fits, std::size_t last, const MayReach& may_reach) {
  std::size_t reach = 1;
  const auto try_step = [&](std::size_t i) {
    if (!may_reach(i)) return false;
    fits = i;
    return true;
  };
  while (fits < last && try_step(std::min(fits + reach, last))) reach *= 2;
  std::size_t too_far = std::min(fits + reach, last);
  while (too_far > fits + 1) {
    const std::size_t middle = fits + (too_far - fits) / 2;
    if (!try_step(middle)) too_far = middle;
  }
  return fits;
}

/// The last of `steps` that may follow the one at `first`, all between them left out. A sample of the
/// vertices guesses it, so that mostly all of them are looked at once.
std::size_t longest_from(Chords& chords, std::span<const std::size_t> steps, std::size_t first,
                         double& deviation) {
  const std::size_t last = steps.size() - 1;
  while (chords.may_guess()) {
    const auto seems_reachable = [&](std::size_t i) {
      return chords.seems_replaceable(steps[first], steps[i]);
    };
    const std::size_t fits = farthest(first + 1, last, seems_reachable);
    if (chords.confirms(steps[first], steps[fits], deviation)) return fits;
  }
  double fitting = 0.0;
  const auto may_reach = [&](std::size_t i) {
    double off = 0.0;
    if (!chords.may_replace(steps[first], steps[i], off)) return false;
    fitting = off;
    return true;
  };
  may_reach(first + 1);  // it may: what is asked for is how far off that is
  const std::size_t fits = farthest(first + 1, last, may_reach);
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
  Chords chords(mesh, vertices, tolerance);
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
