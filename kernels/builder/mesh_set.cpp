#include "builder/mesh_set.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

namespace stbvh {

namespace {

/// A denormal time counts as 0: with flush-to-zero it does in any comparison, on the threads that have it
/// set.
float normal_time(float time) {
  return std::fabs(time) < std::numeric_limits<float>::min() ? 0.0f : time;
}

TimeGrid make_grid(const MeshView& view) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  if (view.steps.size() == 1) return {-inf, inf, inf, 0.0f};
  const TimeRange range{normal_time(view.time_range.begin), normal_time(view.time_range.end)};
  return {range.begin, range.end, range.end - range.begin, static_cast<float>(view.steps.size() - 1)};
}

/// Whether `count` elements of `bytes`, `stride` apart, can lie at `data`: no object takes more than half of
/// the address space.
bool fits_into_memory(const void* data, std::size_t count, std::size_t stride, std::size_t bytes) {
  constexpr std::size_t kMost = std::numeric_limits<std::ptrdiff_t>::max();
  if (stride > kMost) return false;
  if (count == 0) return true;
  if (count - 1 > (kMost - bytes) / stride) return false;
  const std::size_t extent = (count - 1) * stride + bytes;
  return reinterpret_cast<std::uintptr_t>(data) <= std::numeric_limits<std::uintptr_t>::max() - extent;
}

const char* problem_of_indices(const MeshView& mesh) {
  if (mesh.indices == nullptr && mesh.triangle_count > 0) return "has no index buffer";
  if (mesh.triangle_count > kInvalidId) return "has more than 2^32 - 1 triangles";
  if (mesh.index_stride < sizeof(BuildMesh::Triangle)) return "has an index stride below 12 bytes";
  const bool fits =
      fits_into_memory(mesh.indices, mesh.triangle_count, mesh.index_stride, sizeof(BuildMesh::Triangle));
  return fits ? nullptr : "has indices that reach beyond the end of memory";
}

const char* problem_of_step(const VertexBufferView& step) {
  if (step.data == nullptr && step.count > 0) return "lacks the vertex buffer of a step";
  if (step.stride < sizeof(Vec3f)) return "has a vertex stride below 12 bytes";
  const bool fits = fits_into_memory(step.data, step.count, step.stride, sizeof(Vec3f));
  return fits ? nullptr : "has vertices that reach beyond the end of memory";
}

bool is_valid_coordinate(float x) {
  return std::fabs(x) < kMaxCoordinate;
}  // false for NaN

}  // namespace

bool is_usable(const TimeRange& range) {
  const float begin = normal_time(range.begin), end = normal_time(range.end);
  return std::isfinite(begin) && std::isfinite(end) && std::isfinite(end - begin) &&
         end - begin >= std::numeric_limits<float>::min();
}

const char* problem_of(const MeshView& mesh) {
  if (mesh.steps.empty()) return "has no steps";
  if (mesh.steps.size() > kMaxSteps) return "has more than 129 steps";
  if (const char* const problem = problem_of_indices(mesh)) return problem;
  for (const VertexBufferView& step : mesh.steps) {
    if (step.count != mesh.steps[0].count) return "has steps of different vertex counts";
    if (const char* const problem = problem_of_step(step)) return problem;
  }
  if (mesh.steps.size() > 1 && !is_usable(mesh.time_range)) {
    return "has a time range that is empty, not finite, or shorter than 1.18e-38";
  }
  return nullptr;
}

BuildMesh::BuildMesh(const MeshView& view, std::size_t index) : view_(view) {
  if (const char* const problem = problem_of(view)) {
    throw InvalidMesh("mesh " + std::to_string(index) + ": " + problem);
  }
  grid_ = make_grid(view_);
  for (std::uint32_t k = 1; k < segments(); ++k) boundaries_.push_back(first_time_of_segment(grid_, k));
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
