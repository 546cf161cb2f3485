#include "harness/scenes/gltf/adaptive_steps.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "harness/scenes/cancellation.h"

namespace stbvh::harness::gltf {
namespace {

/// Even, so that the middle of a step is looked at: there an arc is furthest from its chord.
constexpr std::size_t kPartsOfStep = 10;
constexpr std::size_t kPartsOfShutter = 64;
/// What refused a number of steps is tried first on the next.
constexpr std::size_t kMostWitnesses = 32;

/// Where a vertex is far from its true place.
struct Witness {
  std::size_t vertex = 0;
  double fraction = 0;  ///< of the shutter
  double deviation = 0;
};

/// Between which steps a moment lies, and how far.
struct Moment {
  std::size_t step = 0;
  double f = 0;
};

Moment moment_at(double fraction, std::size_t segments) {
  const double along = fraction * static_cast<double>(segments);
  const double step = std::clamp(std::floor(along), 0.0, static_cast<double>(segments) - 1);
  return {static_cast<std::size_t>(step), along - step};
}

double distance(const Vec3f& a, const Vec3f& b, double f, const Vec3f& p) {
  const auto off = [f](double from, double to, double at) { return from + f * (to - from) - at; };
  const double length = std::hypot(off(a.x, b.x, p.x), off(a.y, b.y, p.y), off(a.z, b.z, p.z));
  return std::isnan(length) ? std::numeric_limits<double>::infinity() : length;
}

double step_fraction(std::size_t step, std::size_t segments) {
  return static_cast<double>(step) / static_cast<double>(segments);
}

class StepChooser {
 public:
  StepChooser(const Primitive& primitive, const Timeline& timeline, double tolerance)
      : primitive_(primitive), timeline_(timeline), keys_(timeline.key_fractions()), tolerance_(tolerance) {}

  AdaptiveSteps run() {
    for (std::size_t count = 1; count < kMaxSceneSteps; ++count) {
      if (is_refused_by_a_witness(count)) continue;
      std::vector<VertexBuffer> steps = make_steps(count);
      const Witness worst = worst_of(steps, true);
      if (worst.deviation <= tolerance_) return {std::move(steps), worst.deviation};
      if (witnesses_.size() == kMostWitnesses) witnesses_.erase(witnesses_.begin());
      witnesses_.push_back(worst);
    }
    std::vector<VertexBuffer> steps = make_steps(kMaxSceneSteps);
    const double deviation = worst_of(steps, false).deviation;
    return {std::move(steps), deviation};
  }

 private:
  std::vector<VertexBuffer> make_steps(std::size_t count) const {
    std::vector<VertexBuffer> steps(count);
    for_all(count, [&](std::size_t i) {
      const double fraction = count > 1 ? step_fraction(i, count - 1) : 0.0;
      steps[i] = deform(primitive_, timeline_.rig(), timeline_.pose(fraction));
    });
    return steps;
  }

  bool is_refused_by_a_witness(std::size_t count) const {
    const std::size_t segments = std::max<std::size_t>(count, 2) - 1;
    return std::any_of(witnesses_.rbegin(), witnesses_.rend(), [&](const Witness& witness) {
      const auto place = [&](double fraction) {
        return deform_vertex(primitive_, timeline_.rig(), timeline_.pose(fraction), witness.vertex);
      };
      const Moment moment = moment_at(witness.fraction, segments);
      const Vec3f from = place(step_fraction(moment.step, segments));
      const Vec3f to = count == 1 ? from : place(step_fraction(moment.step + 1, segments));
      return distance(from, to, moment.f, place(witness.fraction)) > tolerance_;
    });
  }

  /// When the curve is looked at. The end is for one step only, on more it lies.
  std::vector<double> moments(std::size_t segments) const {
    const std::size_t least = (kPartsOfShutter + segments - 1) / segments;
    const std::size_t parts = segments * std::max(kPartsOfStep, least + least % 2);
    std::vector<double> fractions = keys_;
    for (std::size_t i = 1; i <= parts; ++i) fractions.push_back(step_fraction(i, parts));
    return fractions;
  }

  /// If `may_stop`, any that is beyond the tolerance.
  Witness worst_of(const std::vector<VertexBuffer>& steps, bool may_stop) const {
    const std::size_t segments = std::max<std::size_t>(steps.size(), 2) - 1;
    const std::vector<double> fractions = moments(segments);
    std::vector<Witness> worst(fractions.size());
    std::atomic<bool> is_refused = false;
    for_all(fractions.size(), [&](std::size_t i) {
      if (may_stop && is_refused) return;
      const VertexBuffer truth = deform(primitive_, timeline_.rig(), timeline_.pose(fractions[i]));
      const Moment moment = moment_at(fractions[i], segments);
      const VertexBuffer& from = steps[moment.step];
      const VertexBuffer& to = steps[std::min(moment.step + 1, steps.size() - 1)];
      for (std::size_t v = 0; v < truth.size(); ++v) {
        const double deviation = distance(from[v], to[v], moment.f, truth[v]);
        if (deviation > worst[i].deviation) worst[i] = {v, fractions[i], deviation};
      }
      if (worst[i].deviation > tolerance_) is_refused = true;
    });
    return *std::max_element(worst.begin(), worst.end(),
                             [](const Witness& a, const Witness& b) { return a.deviation < b.deviation; });
  }

  const Primitive& primitive_;
  const Timeline& timeline_;
  const std::vector<double> keys_;
  const double tolerance_;
  std::vector<Witness> witnesses_;
};

}  // namespace

AdaptiveSteps choose_steps(const Primitive& primitive, const Timeline& timeline, double tolerance) {
  return StepChooser(primitive, timeline, tolerance).run();
}

}  // namespace stbvh::harness::gltf
