/// Where a triangle is at a time, in double precision: the contract that every structure shares
/// (docs/algorithm.md), without any of a structure's roundings.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// Segment of a mesh that a time falls into, and how far it is along it, 0 to 1.
struct MotionSample {
  std::size_t segment = 0;
  double fraction = 0;
};

/// Whether `mesh` can be hit at `time` at all.
inline bool is_visible_at(const Mesh& mesh, float time) {
  const TimeRange range = mesh.motion_range();
  return mesh.is_static() || (time >= range.begin && time <= range.end);
}

/// The last segment that has begun at `time`, of a mesh with step times that is visible then.
inline std::size_t segment_among_times(const Mesh& mesh, float time) {
  const auto last = mesh.step_times.end() - 1;  // at which no segment begins
  const auto behind = std::upper_bound(mesh.step_times.begin() + 1, last, time);
  return static_cast<std::size_t>(behind - mesh.step_times.begin()) - 1;
}

/// u = (t - a) / (b - a) * S, k = min(floor(u), S - 1), f = u - k; with step times the last k < S with
/// t_k <= t, f = (t - t_k) / (t_(k+1) - t_k). The mesh is visible at `time`.
inline MotionSample motion_sample(const Mesh& mesh, float time) {
  const std::size_t segments = mesh.segment_count();
  if (segments == 0) return {};
  if (mesh.has_step_times()) {
    const std::size_t k = segment_among_times(mesh, time);
    const double begin = mesh.step_times[k];
    return {k, (time - begin) / (mesh.step_times[k + 1] - begin)};
  }
  const double a = mesh.time_range.begin;
  const double b = mesh.time_range.end;
  const double u = (time - a) / (b - a) * static_cast<double>(segments);
  const auto k = static_cast<std::size_t>(u);
  const std::size_t segment = k < segments ? k : segments - 1;
  return {segment, u - static_cast<double>(segment)};
}

inline Vec3 position_at(const Mesh& mesh, std::uint32_t vertex, MotionSample sample) {
  const Vec3 begin = to_double(mesh.steps[sample.segment][vertex]);
  if (mesh.is_static()) return begin;
  return lerp(begin, to_double(mesh.steps[sample.segment + 1][vertex]), sample.fraction);
}

/// Corners of triangle `prim`, whose indices are in range.
inline std::array<Vec3, 3> triangle_at(const Mesh& mesh, std::size_t prim, MotionSample sample) {
  const std::uint32_t* v = &mesh.indices[3 * prim];
  return {position_at(mesh, v[0], sample), position_at(mesh, v[1], sample), position_at(mesh, v[2], sample)};
}

/// Whether a structure may hit triangle `prim` at all: indices in range, every step finite and below
/// kMaxCoordinate.
inline bool is_valid_triangle(const Mesh& mesh, std::size_t prim) {
  const auto is_valid = [](float x) { return std::abs(x) < kMaxCoordinate; };
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint32_t v = mesh.indices[3 * prim + c];
    for (const VertexBuffer& step : mesh.steps) {
      if (v >= step.size()) return false;
      const Vec3f p = step[v];
      if (!is_valid(p.x) || !is_valid(p.y) || !is_valid(p.z)) return false;
    }
  }
  return true;
}

}  // namespace stbvh::harness
