#include "mesh_contract.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>

#include "require.h"

namespace stbvh::fuzz {

namespace {

Vec3f position(const MeshView& mesh, std::size_t step, std::uint32_t vertex) {
  Vec3f p;
  std::memcpy(&p, static_cast<const char*>(mesh.steps[step].data) + vertex * mesh.steps[step].stride,
              sizeof p);
  return p;
}

bool is_valid(const MeshView& mesh, std::uint32_t vertex) {
  if (vertex >= mesh.steps[0].count) return false;
  for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
    const Vec3f p = position(mesh, step, vertex);
    for (const float x : {p.x, p.y, p.z}) {
      if (!(std::fabs(x) < kMaxCoordinate)) return false;
    }
  }
  return true;
}

/// When a mesh of several steps is alive.
TimeRange alive(const MeshView& mesh) {
  return mesh.step_times.empty() ? mesh.time_range
                                 : TimeRange{mesh.step_times.front(), mesh.step_times.back()};
}

/// Where a time lies among the steps: in segments from the first on.
double along(const MeshView& mesh, float time) {
  const auto segments = static_cast<float>(mesh.steps.size() - 1);
  const TimeRange range = mesh.time_range;
  if (mesh.step_times.empty()) return (time - range.begin) / (range.end - range.begin) * segments;
  std::size_t k = 0;
  while (k + 2 < mesh.step_times.size() && mesh.step_times[k + 1] <= time) ++k;
  const double begin = mesh.step_times[k], end = mesh.step_times[k + 1];
  return static_cast<double>(k) + (time - begin) / (end - begin);
}

/// The position at a time of the mesh's range, in double but for the choice of the segment.
std::array<double, 3> position_at(const MeshView& mesh, float time, std::uint32_t vertex) {
  const Vec3f p = position(mesh, 0, vertex);
  if (mesh.steps.size() == 1) return {p.x, p.y, p.z};
  const double u = along(mesh, time);
  const double k = std::min(std::floor(u), static_cast<double>(mesh.steps.size() - 2));
  const double f = u - k;
  const Vec3f p0 = position(mesh, static_cast<std::size_t>(k), vertex);
  const Vec3f p1 = position(mesh, static_cast<std::size_t>(k) + 1, vertex);
  return {(1 - f) * p0.x + f * p1.x, (1 - f) * p0.y + f * p1.y, (1 - f) * p0.z + f * p1.z};
}

/// Up to what a build that flushes denormal numbers to zero leaves out, and the rounding of straight motion.
bool holds(const Box3f& box, const std::array<double, 3>& p) {
  constexpr double kFlushed = std::numeric_limits<float>::min();
  const std::array<float, 3> lower{box.lower.x, box.lower.y, box.lower.z};
  const std::array<float, 3> upper{box.upper.x, box.upper.y, box.upper.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slack = kFlushed + 0x1p-22 * std::fabs(p[axis]);
    if (!(p[axis] >= lower[axis] - slack && p[axis] <= upper[axis] + slack)) return false;
  }
  return true;
}

}  // namespace

/// Denormal times count as 0.
static float normal(float time) {
  return std::fabs(time) < std::numeric_limits<float>::min() ? 0.0f : time;
}

/// Elements of `bytes`, `stride` apart, end within memory, and take no more than half of it.
static bool fits(const void* data, std::size_t count, std::size_t stride, std::size_t bytes) {
  using Wide = unsigned __int128;
  constexpr Wide kHalf = std::numeric_limits<std::ptrdiff_t>::max();
  const Wide extent = count == 0 ? 0 : Wide{count - 1} * stride + bytes;
  const Wide end = Wide{reinterpret_cast<std::uintptr_t>(data)} + extent;
  return stride <= kHalf && extent <= kHalf && end <= std::numeric_limits<std::uintptr_t>::max();
}

bool is_readable(const MeshView& mesh) {
  if (mesh.steps.empty() || mesh.steps.size() > kMaxSteps) return false;
  if (mesh.indices == nullptr && mesh.triangle_count > 0) return false;
  if (mesh.triangle_count > kInvalidId || mesh.index_stride < 3 * sizeof(std::uint32_t)) return false;
  if (!fits(mesh.indices, mesh.triangle_count, mesh.index_stride, 3 * sizeof(std::uint32_t))) return false;
  for (const VertexBufferView& step : mesh.steps) {
    if (!fits(step.data, step.count, step.stride, sizeof(Vec3f))) return false;
    if (step.count != mesh.steps[0].count || step.stride < sizeof(Vec3f)) return false;
    if (step.data == nullptr && step.count > 0) return false;
  }
  if (mesh.steps.size() == 1) return true;
  const auto follow = [](float first, float second) {
    const float begin = normal(first), end = normal(second);
    return std::isfinite(begin) && std::isfinite(end) && std::isfinite(end - begin) &&
           end - begin >= std::numeric_limits<float>::min();
  };
  if (mesh.step_times.empty()) return follow(mesh.time_range.begin, mesh.time_range.end);
  if (mesh.step_times.size() != mesh.steps.size()) return false;
  for (std::size_t i = 1; i < mesh.step_times.size(); ++i) {
    if (!follow(mesh.step_times[i - 1], mesh.step_times[i])) return false;
  }
  return follow(mesh.step_times.front(), mesh.step_times.back());
}

std::vector<std::array<std::uint32_t, 3>> valid_triangles(const MeshView& mesh) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t prim = 0; prim < mesh.triangle_count; ++prim) {
    std::array<std::uint32_t, 3> corners;
    std::memcpy(&corners, static_cast<const char*>(mesh.indices) + prim * mesh.index_stride, sizeof corners);
    if (std::all_of(corners.begin(), corners.end(), [&](auto vertex) { return is_valid(mesh, vertex); })) {
      triangles.push_back(corners);
    }
  }
  return triangles;
}

bool is_ever_alive(const MeshView& mesh) {
  return mesh.steps.size() == 1 || (alive(mesh).begin <= 1.0f && normal(alive(mesh).end) >= 0.0f);
}

void check_statistics(std::span<const MeshView> meshes, float tolerance, const BuildStatistics& statistics) {
  std::size_t triangles = 0, invalid = 0, segments = 0, steps = 0;
  for (const MeshView& mesh : meshes) {
    steps += mesh.steps.size();
    const std::size_t valid = valid_triangles(mesh).size();
    invalid += mesh.triangle_count - valid;
    if (!is_ever_alive(mesh)) continue;
    triangles += valid;
    segments += valid * std::max<std::size_t>(mesh.steps.size() - 1, 1);
  }
  const BuildStatistics& s = statistics;
  require(s.triangles == triangles, "statistics: triangles");
  require(s.invalid_triangles == invalid, "statistics: invalid_triangles");
  require(s.primitive_segments <= segments && s.primitive_segments >= triangles,
          "statistics: primitive_segments");
  require(s.steps_given == steps, "statistics: steps_given");
  require(s.steps_kept <= steps && s.steps_kept >= meshes.size(), "statistics: steps_kept");
  if (tolerance == kKeepAllSteps) {
    require(s.primitive_segments == segments && s.steps_kept == steps && s.max_deviation == 0,
            "statistics: all steps are kept");
  }

  std::size_t nodes = 0, children = 0;
  for (std::size_t kind = 0; kind < s.nodes.size(); ++kind) {
    require(s.node_children[kind] >= 2 * s.nodes[kind] && s.node_children[kind] <= 8 * s.nodes[kind],
            "statistics: 2 to 8 children of each node");
    nodes += s.nodes[kind];
    children += s.node_children[kind];
  }
  const std::size_t leaves = s.inline_leaves + s.indexed_leaves;
  require((leaves > 0) == (triangles > 0), "statistics: leaves where there are triangles");
  require(nodes == 0 ? leaves <= 1 : children + 1 == nodes + leaves,
          "statistics: each but the root is a child");
  require(s.leaf_triangles >= triangles && s.leaf_triangles <= 8 * leaves, "statistics: leaf_triangles");
  require((s.depth > 0) == (nodes > 0) && s.depth <= nodes && s.depth < 90, "statistics: depth");
  require(s.leaf_bytes >= 160 * s.inline_leaves + 64 * (s.indexed_leaves > 0), "statistics: leaf_bytes");
  require(s.leaf_bytes <= s.structure_bytes && s.structure_bytes <= s.wanted_bytes, "statistics: bytes");
  require(s.peak_bytes >= s.structure_bytes, "statistics: peak_bytes");
}

void check_bounds(std::span<const MeshView> meshes, const Structure& structure, float time) {
  if (!(time >= 0.0f && time <= 1.0f)) return;
  const Box3f box = structure.bounds_at(time);
  for (const MeshView& mesh : meshes) {
    if (mesh.steps.size() > 1 && !(time >= alive(mesh).begin && time <= alive(mesh).end)) continue;
    for (const auto& triangle : valid_triangles(mesh)) {
      for (const std::uint32_t vertex : triangle) {
        const std::array<double, 3> p = position_at(mesh, time, vertex);
        if (holds(box, p)) continue;
        std::fprintf(stderr,
                     "mesh %td, vertex %u at (%a, %a, %a), box (%a, %a, %a) to (%a, %a, %a), time %a\n",
                     &mesh - meshes.data(), vertex, p[0], p[1], p[2], box.lower.x, box.lower.y, box.lower.z,
                     box.upper.x, box.upper.y, box.upper.z, time);
        require(false, "bounds_at: holds all triangles");
      }
    }
  }
}

}  // namespace stbvh::fuzz
