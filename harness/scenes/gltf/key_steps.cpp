#include "harness/scenes/gltf/key_steps.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness::gltf {
namespace {

/// What is looked at between two keys without a step between them, and between steps.
constexpr std::size_t kPartsOfInterval = 10;
constexpr std::size_t kPartsOfStep = 4;
/// Two places that are computed in different ways, and rounded to float, differ by less, of the largest
/// coordinate.
constexpr double kRounding = 0x1p-22;
/// Ray times below this are 0: floats from here on are as far apart as steps must be (MeshView).
constexpr double kLeastTime = 0x1p-100;
/// So that it grows where a scene has no diagonal.
constexpr double kLeastTolerance = 1e-38;
/// By how much the tolerance grows where there would be too many steps.
constexpr double kMoreTolerance = 4;

/// Where a key is, or an end of the shutter.
struct Knot {
  float time;            ///< of rays
  double before, after;  ///< of the clip
};

struct Step {
  float time;
  VertexBuffer positions;
};

/// What a mesh does between two knots: the clip runs on evenly.
struct Interval {
  float begin, end;  ///< of rays
  double clip_begin, clip_end;
  const VertexBuffer *from, *to;  ///< at its ends
  double deviation = 0;           ///< without steps between them

  double length() const { return static_cast<double>(end) - begin; }
  double fraction(float time) const { return (static_cast<double>(time) - begin) / length(); }
  double clip_time(double f) const { return clip_begin + f * (clip_end - clip_begin); }
};

/// Steps between the ends of an interval, and how far vertices are from their true places then.
struct Fit {
  std::vector<Step> steps;
  double deviation = 0;
};

/// How far vertices that lie between `a` and `b` are from `truth`; 0 where that is what positions round by.
double deviation(const VertexBuffer& a, const VertexBuffer& b, double f, const VertexBuffer& truth) {
  double worst = 0;
  float largest = 0;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    // Others are left out of the scene.
    if (!is_valid_position(a[v]) || !is_valid_position(b[v]) || !is_valid_position(truth[v])) continue;
    for (const Vec3f& p : {a[v], b[v], truth[v]})
      largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    worst = std::max(worst, length(lerp(to_double(a[v]), to_double(b[v]), f) - to_double(truth[v])));
  }
  return worst > kRounding * static_cast<double>(largest) ? worst : 0;
}

class KeyStepMaker {
 public:
  KeyStepMaker(const Primitive& primitive, const Timeline& timeline, TimeRange range, double tolerance,
               double most_bytes)
      : primitive_(primitive),
        timeline_(timeline),
        range_{normal_ray_time(range.begin), range.end},
        tolerance_(std::max(tolerance, kLeastTolerance)),
        most_steps_in_memory_(most_bytes /
                              static_cast<double>(primitive.geometry->vertex_count() * sizeof(Vec3f))) {}

  KeySteps run() {
    std::vector<Knot> knots = find_knots();
    std::vector<Step> steps = knot_steps(knots);
    while (steps.size() > kMaxSteps) {
      leave_out_every_second(knots);
      steps = knot_steps(knots);
    }
    const std::vector<Interval> intervals = find_intervals(knots, steps);
    for (double tolerance = tolerance_;; tolerance *= kMoreTolerance) {
      if (std::optional<std::vector<Fit>> fits = fit(intervals, steps.size(), tolerance))
        return merged(knots, std::move(steps), std::move(*fits));
    }
  }

 private:
  static float normal_ray_time(double time) { return time < kLeastTime ? 0.0f : static_cast<float>(time); }

  float ray_time(double fraction) const {
    const double begin = range_.begin;
    return normal_ray_time(begin + (range_.end - begin) * fraction);
  }

  VertexBuffer positions(double clip_time, Side side) const {
    return deform(primitive_, timeline_.rig(), timeline_.rig().pose(clip_time, side));
  }

  /// Keys whose ray times are the same float are one.
  std::vector<Knot> find_knots() const {
    const double first = timeline_.clip_time(0), last = timeline_.clip_time(1);
    std::vector<Knot> knots{{range_.begin, first, first}};
    for (const Timeline::Moment& moment : timeline_.moments()) {
      const float time = ray_time(moment.fraction);
      if (time == knots.back().time) {
        knots.back().after = moment.after;
      } else {
        knots.push_back({time, moment.before, moment.after});
      }
    }
    if (knots.back().time < range_.end) knots.push_back({range_.end, last, last});
    knots.back().after = last;  // as when the shutter closes, also where a clip begins again just then
    while (knots.size() > kMaxSteps) leave_out_every_second(knots);
    return knots;
  }

  static void leave_out_every_second(std::vector<Knot>& knots) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      if (i % 2 == 0 || i + 1 == knots.size()) knots[kept++] = knots[i];
    }
    knots.resize(kept);
  }

  void check_memory(std::size_t steps) const {
    if (static_cast<double>(steps) > most_steps_in_memory_)
      fail("its steps at keys would need more memory than a file of its size may");
  }

  /// One at each knot, two where something jumps.
  std::vector<Step> knot_steps(const std::vector<Knot>& knots) const {
    check_memory(knots.size());
    std::vector<VertexBuffer> before(knots.size()), after(knots.size());
    for_all(knots.size(), [&](std::size_t i) {
      after[i] = positions(knots[i].after, Side::kAfter);
      if (i == 0) return;
      VertexBuffer left = positions(knots[i].before, Side::kBefore);
      if (deviation(left, left, 0, after[i]) > 0) before[i] = std::move(left);
    });
    std::vector<Step> steps;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      const float just_before = std::nextafter(knots[i].time, -std::numeric_limits<float>::infinity());
      const bool jumps = before[i].size() > 0 && just_before > steps.back().time;
      if (jumps) steps.push_back({just_before, std::move(before[i])});
      steps.push_back({knots[i].time, std::move(after[i])});
    }
    check_memory(steps.size());
    return steps;
  }

  /// Between knots. They point to `steps`.
  std::vector<Interval> find_intervals(const std::vector<Knot>& knots, const std::vector<Step>& steps) const {
    std::vector<Interval> intervals(knots.size() - 1);
    for_all(intervals.size(), [&](std::size_t i) {
      const auto from = std::lower_bound(steps.begin(), steps.end(), knots[i].time,
                                         [](const Step& step, float time) { return step.time < time; });
      intervals[i] = {knots[i].time,       knots[i + 1].time, knots[i].after,
                      knots[i + 1].before, &from->positions,  &std::next(from)->positions};
      intervals[i].deviation = worst_deviation(intervals[i], {});
    });
    return intervals;
  }

  /// For each interval; nothing where there would be more steps than a mesh can have, with `count` at knots.
  std::optional<std::vector<Fit>> fit(const std::vector<Interval>& intervals, std::size_t count,
                                      double tolerance) const {
    std::vector<Fit> fits(intervals.size());
    std::atomic<std::size_t> total = count;
    for_all(fits.size(), [&](std::size_t i) { fits[i] = fit(intervals[i], tolerance, total); });
    if (total > kMaxSteps) return std::nullopt;
    return fits;
  }

  /// Of the fewest parts that keep within `tolerance`, or of all that floats tell apart. Adds its steps to
  /// `count`, and ends early where that is too many.
  Fit fit(const Interval& interval, double tolerance, std::atomic<std::size_t>& count) const {
    Fit best{{}, interval.deviation};
    if (best.deviation <= tolerance) return best;
    bool is_found = false;
    std::size_t too_few = 1, growth = 1;
    std::optional<std::size_t> enough;  // or more than there are floats for
    while (count <= kMaxSteps) {
      std::size_t parts = 0;
      if (enough) {
        if (*enough - too_few <= 1) break;
        parts = too_few + (*enough - too_few) / 2;
      } else {
        // A curve's distance from its chord falls with the square of the chord's length.
        const double guess = 0.95 * static_cast<double>(too_few) * std::sqrt(best.deviation / tolerance);
        const auto at_least = static_cast<std::size_t>(std::min(guess, double{kMaxSteps}));
        const std::size_t most = kMaxSteps + 1 - std::min<std::size_t>(count, kMaxSteps + 1);
        if (most <= too_few || at_least > most) {
          count += std::max(too_few, at_least);
          return best;
        }
        parts = std::min(most, std::max(too_few + growth, at_least));
        growth *= 2;  // one more at a time would take a time that grows with the square of their number
      }
      std::optional<std::vector<Step>> steps = steps_inside(interval, parts);
      if (!steps) {
        enough = parts;
        continue;
      }
      Fit found{std::move(*steps), 0};
      found.deviation = worst_deviation(interval, found.steps);
      const bool is_enough = found.deviation <= tolerance;
      if (is_enough) {
        enough = parts;
      } else {
        too_few = parts;
      }
      if (is_enough || !is_found) best = std::move(found);
      is_found = is_found || is_enough;
    }
    count += best.steps.size();
    check_memory(count);
    return best;
  }

  /// Steps that cut `interval` into equal parts; nothing where two would be at the same time.
  std::optional<std::vector<Step>> steps_inside(const Interval& interval, std::size_t parts) const {
    std::vector<Step> steps(parts - 1);
    float last = interval.begin;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const double f = static_cast<double>(i + 1) / static_cast<double>(parts);
      steps[i].time = static_cast<float>(interval.begin + f * interval.length());
      if (steps[i].time <= last) return std::nullopt;
      last = steps[i].time;
    }
    // The last float may be that of a step before a jump.
    if (parts > 1 && std::nextafter(last, interval.end) >= interval.end) return std::nullopt;
    for_all(steps.size(), [&](std::size_t i) {
      steps[i].positions = positions(interval.clip_time(interval.fraction(steps[i].time)), Side::kAfter);
    });
    return steps;
  }

  double worst_deviation(const Interval& interval, const std::vector<Step>& inside) const {
    const std::size_t parts_of_step = inside.empty() ? kPartsOfInterval : kPartsOfStep;
    const std::size_t looks = parts_of_step - 1;
    std::vector<double> worst((inside.size() + 1) * looks);
    for_all(worst.size(), [&](std::size_t i) {
      const std::size_t part = i / looks;
      const double f = static_cast<double>(i % looks + 1) / static_cast<double>(parts_of_step);
      const double begin = part == 0 ? 0 : interval.fraction(inside[part - 1].time);
      const double end = part == inside.size() ? 1 : interval.fraction(inside[part].time);
      const VertexBuffer truth = positions(interval.clip_time(begin + f * (end - begin)), Side::kAfter);
      worst[i] = deviation(part == 0 ? *interval.from : inside[part - 1].positions,
                           part == inside.size() ? *interval.to : inside[part].positions, f, truth);
    });
    return *std::max_element(worst.begin(), worst.end());
  }

  static KeySteps merged(const std::vector<Knot>& knots, std::vector<Step> at_knots, std::vector<Fit> fits) {
    KeySteps result;
    const auto add = [&](Step& step) {
      result.times.push_back(step.time);
      result.steps.push_back(std::move(step.positions));
    };
    auto step = at_knots.begin();
    for (std::size_t i = 0; i < knots.size(); ++i) {
      for (; step != at_knots.end() && step->time <= knots[i].time; ++step) add(*step);
      if (i == fits.size()) break;
      for (Step& inside : fits[i].steps) add(inside);
      result.deviation = std::max(result.deviation, fits[i].deviation);
    }
    return result;
  }

  const Primitive& primitive_;
  const Timeline& timeline_;
  const TimeRange range_;
  const double tolerance_;
  const double most_steps_in_memory_;
};

}  // namespace

KeySteps steps_at_keys(const Primitive& primitive, const Timeline& timeline, TimeRange range,
                       double tolerance, double most_bytes) {
  return KeyStepMaker(primitive, timeline, range, tolerance, most_bytes).run();
}

}  // namespace stbvh::harness::gltf
