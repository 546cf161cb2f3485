#include "builder/build_mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>

namespace stbvh {

namespace {

const MeshView& checked(const MeshView& view, std::size_t index) {
  if (const char* const problem = problem_of(view))
    throw InvalidMesh("mesh " + std::to_string(index) + ": " + problem);
  return view;
}

}  // namespace

TimeGrid time_grid_of(const MeshView& view) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  if (view.steps.size() == 1) return {-inf, inf, inf, 0.0f};
  const auto segments = static_cast<float>(view.steps.size() - 1);
  if (!view.step_times.empty()) {
    const float begin = view.step_times.front(), end = view.step_times.back();
    return {begin, end, end - begin, -segments};
  }
  const TimeRange range{normal_time(view.time_range.begin), normal_time(view.time_range.end)};
  return {range.begin, range.end, range.end - range.begin, segments};
}

namespace {

bool is_equidistant(const std::vector<std::size_t>& steps) {
  for (std::size_t i = 2; i < steps.size(); ++i) {
    if (steps[i] - steps[i - 1] != steps[1] - steps[0]) return false;
  }
  return true;
}

}  // namespace

BuildMesh::BuildMesh(const MeshView& view, std::size_t index)
    : view_(checked(view, index)),
      index_(static_cast<std::uint32_t>(index)),
      steps_given_(view.steps.size()),
      kept_(view.steps.size()) {
  std::iota(kept_.begin(), kept_.end(), std::size_t{0});
  if (is_static()) view_.step_times = {};  // not looked at
  for (const float time : view_.step_times) times_.push_back(normal_time(time));
  view_.step_times = times_;
}

BuildMesh::BuildMesh(const MeshView& view, std::size_t index, float tolerance) : BuildMesh(view, index) {
  find_invalid_vertices();
  if (!is_static() && tolerance >= 0.0f) {
    const auto valid = [this](std::size_t vertex) {
      return is_invalid(vertex) ? kNoVertex : static_cast<std::uint32_t>(vertex);
    };
    keep(reduce_steps(view_, {view_.steps[0].count, valid}, kept_, tolerance));
  }
  make_grid();
}

BuildMesh::BuildMesh(const BuildMesh& whole, const MeshView& view, MeshPart part, BuildMemory& memory)
    : BuildMesh(view, whole.index()) {
  prims_ = std::make_unique<TemporaryArray<std::uint32_t>>(memory, part.prims.size());
  std::ranges::copy(part.prims, prims_->data());
  invalid_vertices_ = whole.invalid_vertices_;
  keep(std::move(part.steps));
  make_grid();
}

void BuildMesh::keep(StepReduction reduction) {
  deviation_ = reduction.deviation;
  if (reduction.kept.size() == view_.steps.size()) return;
  std::vector<float> times;
  for (const std::size_t step : reduction.kept) {
    steps_.push_back(view_.steps[step]);
    times.push_back(step_time(view_, step));
  }
  const bool is_static = reduction.kept.size() == 1;
  if (is_static || (view_.step_times.empty() && is_equidistant(reduction.kept))) times.clear();
  view_.steps = steps_;
  times_ = std::move(times);
  view_.step_times = times_;
  kept_ = std::move(reduction.kept);
}

void BuildMesh::make_grid() {
  if (times_.size() == 2) {  // are equidistant
    view_.time_range = {times_[0], times_[1]};
    times_.clear();
    view_.step_times = {};
  }
  grid_ = time_grid_of(view_);
  if (grid_.is_uneven()) {
    boundaries_.assign(times_.begin() + 1, times_.end() - 1);
    return;
  }
  for (std::uint32_t k = 1; k < segments(); ++k) boundaries_.push_back(first_time_of_segment(grid_, k));
}

void BuildMesh::find_invalid_vertices() {
  const std::size_t count = view_.steps[0].count;
  const auto is_invalid_at = [&](const VertexBufferView& step, std::size_t vertex) {
    return !is_valid_position(step.position(vertex));
  };
  std::atomic<bool> any{false};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 16384), [&](const auto& range) {
    for (const VertexBufferView& step : view_.steps) {
      for (std::size_t v = range.begin(); v != range.end(); ++v) {
        if (!is_invalid_at(step, v)) continue;
        any.store(true, std::memory_order_relaxed);
        return;
      }
    }
  });
  if (!any.load()) return;
  invalid_vertices_.resize(count);
  for (const VertexBufferView& step : view_.steps) {
    for (std::size_t v = 0; v < count; ++v) {
      if (is_invalid_at(step, v)) invalid_vertices_[v] = true;
    }
  }
}

bool BuildMesh::is_valid(const TriangleIndices& triangle) const {
  for (const std::uint32_t v : triangle) {
    if (v >= view_.steps[0].count) return false;
    if (is_invalid(v)) return false;
  }
  return true;
}

ClosedTimeRange BuildMesh::alive(const ClosedTimeRange& range) const {
  return {std::max(range.begin, grid_.begin), std::min(range.last, grid_.end)};
}

BuildMesh::SegmentRange BuildMesh::segments_in(const ClosedTimeRange& range) const {
  const ClosedTimeRange r = alive(range);
  return {segment_at(r.begin).segment, segment_at(r.last).segment};
}

std::size_t BuildMesh::steps_in(const ClosedTimeRange& range) const {
  if (is_static()) return 1;
  const ClosedTimeRange r = alive(range);
  if (!(r.begin <= r.last)) return 0;
  const SegmentRange met = segments_in(r);
  return std::size_t{met.last} - met.first + 2;
}

SegmentTime BuildMesh::segment_at(float time) const {
  if (!grid_.is_uneven()) return stbvh::segment_at(grid_, time);
  return segment_among(times_.data(), 0, static_cast<std::uint32_t>(segments()) - 1, time);
}

double BuildMesh::time_of_step(std::size_t step) const {
  if (grid_.is_uneven()) return times_[step];
  return grid_.begin +
         (static_cast<double>(grid_.end) - grid_.begin) * static_cast<double>(step) / grid_.segments;
}

float BuildMesh::segments_per_time(const ClosedTimeRange& range) const {
  if (!grid_.is_uneven()) return grid_.segments / grid_.length;
  const ClosedTimeRange r = alive(range);
  if (!(r.begin < r.last)) return 0.0f;
  const SegmentRange met = segments_in(r);
  return static_cast<float>(met.last - met.first + 1) / r.length();
}

namespace {

/// Floats as integers of the same order.
std::int32_t ordered(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  return bits >= 0 ? bits : std::numeric_limits<std::int32_t>::min() - bits;
}
float from_ordered(std::int32_t i) {
  return std::bit_cast<float>(i >= 0 ? i : std::numeric_limits<std::int32_t>::min() - i);
}

}  // namespace

float first_time_of_segment(const TimeGrid& grid, std::uint32_t segment) {
  std::int64_t below = ordered(grid.begin);  // segment 0
  std::int64_t reached = ordered(grid.end);  // the last segment
  while (reached - below > 1) {
    const std::int64_t middle = below + (reached - below) / 2;
    const float time = from_ordered(static_cast<std::int32_t>(middle));
    (segment_at(grid, time).segment >= segment ? reached : below) = middle;
  }
  return from_ordered(static_cast<std::int32_t>(reached));
}

std::optional<float> BuildMesh::central_boundary(const ClosedTimeRange& range) const {
  const float centre = 0.5f * range.begin + 0.5f * range.last;
  std::optional<float> best;
  const auto consider = [&](std::vector<float>::const_iterator it) {
    if (it == boundaries_.end() || *it <= range.begin || *it > range.last) return;
    if (!best || std::fabs(*it - centre) < std::fabs(*best - centre)) best = *it;
  };
  const auto above = std::lower_bound(boundaries_.begin(), boundaries_.end(), centre);
  if (above != boundaries_.begin()) consider(above - 1);
  consider(above);
  return best;
}

}  // namespace stbvh
