#include "build/mesh_set.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

namespace stbvh {

namespace {

TimeGrid make_grid(const MeshView& view) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  if (view.steps.size() == 1) return {-inf, inf, inf, 0.0f};
  const TimeRange range = view.time_range;
  return {range.begin, range.end, range.end - range.begin, static_cast<float>(view.steps.size() - 1)};
}

void check(bool condition, std::size_t index, const char* what) {
  if (!condition) throw InvalidMesh("mesh " + std::to_string(index) + ": " + what);
}

bool is_valid_coordinate(float x) {
  return std::fabs(x) < kMaxCoordinate;
}  // false for NaN

}  // namespace

BuildMesh::BuildMesh(const MeshView& view, std::size_t index) : view_(view) {
  check(!view.steps.empty(), index, "has no steps");
  check(view.steps.size() <= kMaxSteps, index, "has more than 129 steps");
  check(view.indices != nullptr || view.triangle_count == 0, index, "has no index buffer");
  check(view.triangle_count <= kInvalidId, index, "has more than 2^32 - 1 triangles");
  check(view.index_stride >= sizeof(Triangle), index, "has an index stride below 12 bytes");
  for (const VertexBufferView& step : view.steps) {
    check(step.count == view.steps[0].count, index, "has steps of different vertex counts");
    check(step.data != nullptr || step.count == 0, index, "lacks the vertex buffer of a step");
    check(step.stride >= sizeof(Vec3f), index, "has a vertex stride below 12 bytes");
  }
  if (view.steps.size() > 1) {
    const TimeRange range = view.time_range;
    check(std::isfinite(range.begin) && std::isfinite(range.end) && range.begin < range.end &&
              std::isfinite(range.end - range.begin),
          index, "has a time range that is empty or not finite");
  }
  grid_ = make_grid(view_);
  find_invalid_vertices();
}

void BuildMesh::find_invalid_vertices() {
  const std::size_t count = view_.steps[0].count;
  const auto is_invalid = [&](std::size_t vertex) {
    for (std::size_t step = 0; step < view_.steps.size(); ++step) {
      const Vec3f p = position(step, static_cast<std::uint32_t>(vertex));
      if (!is_valid_coordinate(p.x) || !is_valid_coordinate(p.y) || !is_valid_coordinate(p.z)) return true;
    }
    return false;
  };
  std::atomic<bool> any{false};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 16384), [&](const auto& range) {
    for (std::size_t v = range.begin(); v != range.end(); ++v) {
      if (is_invalid(v)) {
        any.store(true, std::memory_order_relaxed);
        return;
      }
    }
  });
  if (!any.load()) return;
  invalid_vertices_.resize(count);
  for (std::size_t v = 0; v < count; ++v) invalid_vertices_[v] = is_invalid(v);
}

bool BuildMesh::is_valid(const Triangle& triangle) const {
  for (const std::uint32_t v : triangle.vertex) {
    if (v >= view_.steps[0].count) return false;
    if (!invalid_vertices_.empty() && invalid_vertices_[v]) return false;
  }
  return true;
}

ClosedTimeRange BuildMesh::alive(const ClosedTimeRange& range) const {
  return {std::max(range.begin, grid_.begin), std::min(range.last, grid_.end)};
}

BuildMesh::SegmentRange BuildMesh::segments_in(const ClosedTimeRange& range) const {
  const ClosedTimeRange r = alive(range);
  return {segment_at(grid_, r.begin).segment, segment_at(grid_, r.last).segment};
}

float first_time_of_segment(const TimeGrid& grid, std::uint32_t segment) {
  const double fraction = static_cast<double>(segment) / static_cast<double>(grid.segments);
  constexpr float inf = std::numeric_limits<float>::infinity();
  float t = static_cast<float>(grid.begin + fraction * (static_cast<double>(grid.end) - grid.begin));
  t = std::clamp(t, grid.begin, grid.end);
  while (t > grid.begin && segment_at(grid, std::nextafter(t, -inf)).segment >= segment)
    t = std::nextafter(t, -inf);
  while (t < grid.end && segment_at(grid, t).segment < segment) t = std::nextafter(t, inf);
  return t;
}

}  // namespace stbvh
