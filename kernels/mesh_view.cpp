#include "stbvh/mesh_view.h"

#include <cmath>
#include <limits>

#include "layout/time_grid.h"
#include "stbvh/structure.h"

namespace stbvh {

bool fits_into_memory(const void* data, std::size_t count, std::size_t stride, std::size_t bytes) {
  constexpr std::size_t kMost = std::numeric_limits<std::ptrdiff_t>::max();
  if (stride > kMost) return false;
  if (count == 0) return true;
  if (count - 1 > (kMost - bytes) / stride) return false;
  const std::size_t extent = (count - 1) * stride + bytes;
  return reinterpret_cast<std::uintptr_t>(data) <= std::numeric_limits<std::uintptr_t>::max() - extent;
}

namespace {

const char* problem_of_indices(const MeshView& mesh) {
  if (mesh.indices == nullptr && mesh.triangle_count > 0) return "has no index buffer";
  if (mesh.triangle_count > kInvalidId) return "has more than 2^32 - 1 triangles";
  if (mesh.index_stride < sizeof(TriangleIndices)) return "has an index stride below 12 bytes";
  const bool fits =
      fits_into_memory(mesh.indices, mesh.triangle_count, mesh.index_stride, sizeof(TriangleIndices));
  return fits ? nullptr : "has indices that reach beyond the end of memory";
}

const char* problem_of_step(const VertexBufferView& step) {
  if (step.data == nullptr && step.count > 0) return "lacks the vertex buffer of a step";
  if (step.stride < sizeof(Vec3f)) return "has a vertex stride below 12 bytes";
  const bool fits = fits_into_memory(step.data, step.count, step.stride, sizeof(Vec3f));
  return fits ? nullptr : "has vertices that reach beyond the end of memory";
}

const char* problem_of_times(const MeshView& mesh) {
  if (mesh.steps.size() == 1) return nullptr;
  if (mesh.step_times.empty()) {
    return is_usable(mesh.time_range)
               ? nullptr
               : "has a time range that is empty, not finite, or shorter than 1.18e-38";
  }
  if (mesh.step_times.size() != mesh.steps.size()) return "has not one time for each step";
  for (std::size_t step = 1; step < mesh.step_times.size(); ++step) {
    if (!is_usable({mesh.step_times[step - 1], mesh.step_times[step]}))
      return "has step times that are not finite, or do not increase by 1.18e-38 or more";
  }
  return is_usable({mesh.step_times.front(), mesh.step_times.back()}) ? nullptr
                                                                      : "has step times too far apart";
}

}  // namespace

bool is_usable(const TimeRange& range) {
  const float begin = normal_time(range.begin), end = normal_time(range.end);
  return std::isfinite(begin) && std::isfinite(end) && std::isfinite(end - begin) &&
         end - begin >= std::numeric_limits<float>::min();
}

const char* problem_of(const MeshView& mesh) {
  if (mesh.steps.empty()) return "has no steps";
  if (mesh.steps.size() > kMaxSteps) return "has more than 4096 steps";
  if (const char* const problem = problem_of_indices(mesh)) return problem;
  for (const VertexBufferView& step : mesh.steps) {
    if (step.count != mesh.steps[0].count) return "has steps of different vertex counts";
    if (const char* const problem = problem_of_step(step)) return problem;
  }
  return problem_of_times(mesh);
}

}  // namespace stbvh
