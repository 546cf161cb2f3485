/// What bounds in other directions than the axes are built of: places of vertices along them, in double.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "builder/binary_node.h"
#include "builder/motion_bounds.h"

namespace stbvh::harness::gallery {

using Point = std::array<double, 3>;
using Direction = std::array<float, 3>;

/// A point that such bounds are made relative to (centred_ray.inl).
inline Vec3f centre_of(const BinaryNode& root) {
  const Box4 whole = root.bounds().whole();
  const F32x4 centre = F32x4(0.5f) * whole.lower + F32x4(0.5f) * whole.upper;
  return {centre[0], centre[1], centre[2]};
}

inline Point relative(const Vec3f& p, const Point& centre) {
  return {p.x - centre[0], p.y - centre[1], p.z - centre[2]};
}

inline Point mixed(const Point& a, const Point& b, double fraction) {
  const auto mix = [&](std::size_t i) { return (1.0 - fraction) * a[i] + fraction * b[i]; };
  return {mix(0), mix(1), mix(2)};
}

inline float rounded_down(double x) {
  const auto nearest = static_cast<float>(x);
  return nearest > x ? std::nextafter(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}
inline float rounded_up(double x) {
  return -rounded_down(-x);
}

struct Interval {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -lower;

  void extend(const Interval& other) {
    lower = std::min(lower, other.lower);
    upper = std::max(upper, other.upper);
  }
};

/// How far vertices of one mesh reach along N directions at all samples of their motion.
template <std::size_t N>
class ProjectedMotion {
 public:
  ProjectedMotion(const BuildMesh& mesh, const MotionSamples& samples, const Point& centre,
                  const std::array<Direction, N>& directions)
      : mesh_(mesh),
        samples_(samples.samples),
        centre_(centre),
        directions_(directions),
        reach_(samples_.size()),
        steps_(mesh.is_static() ? 1 : samples_.back().segment - samples_.front().segment + 2) {}

  void extend(const Meshlet& meshlet) {
    for (const std::uint32_t vertex : meshlet.used_vertices()) extend(vertex);
  }

  /// Of each sample. Between two samples vertices move linearly but for the rounding of the segment's
  /// fraction, which shifts them along their motion: by less than a quarter of what is added
  /// (docs/accuracy.md). All else that rounds is a ray's.
  std::vector<std::array<Interval, N>> padded() const {
    std::vector<std::array<Interval, N>> result = reach_;
    const double rounding =
        mesh_.is_static() ? 0.0 : 0x1p-20 * static_cast<double>(mesh_.fraction_rounding());
    for (auto& sample : result) {
      for (std::size_t i = 0; i < N; ++i) {
        sample[i].lower -= rounding * motion_[i];
        sample[i].upper += rounding * motion_[i];
      }
    }
    return result;
  }

 private:
  void extend(std::uint32_t vertex) {
    const std::uint32_t first = samples_.front().segment;
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      const Point p = relative(mesh_.position(first + k, vertex), centre_);
      for (std::size_t i = 0; i < N; ++i) {
        const Direction& d = directions_[i];
        steps_[k][i] = d[0] * p[0] + d[1] * p[1] + d[2] * p[2];
        if (k > 0) motion_[i] = std::max(motion_[i], std::fabs(steps_[k][i] - steps_[k - 1][i]));
      }
    }
    for (std::size_t at = 0; at < reach_.size(); ++at) {
      const auto& begin = steps_[samples_[at].segment - first];
      const double fraction = samples_[at].fraction;
      for (std::size_t i = 0; i < N; ++i) {
        double place = begin[i];
        if (fraction > 0) place += fraction * ((&begin)[1][i] - place);
        reach_[at][i].extend({place, place});
      }
    }
  }

  const BuildMesh& mesh_;
  const std::vector<MotionSamples::Sample>& samples_;
  const Point centre_;
  const std::array<Direction, N> directions_;
  std::vector<std::array<Interval, N>> reach_;  ///< at each sample
  std::vector<std::array<double, N>> steps_;    ///< of one vertex
  std::array<double, N> motion_{};              ///< largest within a segment
};

}  // namespace stbvh::harness::gallery
