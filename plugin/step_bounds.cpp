#include "plugin/step_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <new>

namespace stbvh::plugin {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// Per vertex: whether it is finite in all steps, and whether a valid triangle uses it.
constexpr std::uint8_t kFinite = 1;
constexpr std::uint8_t kUsed = 2;

Vec3f vertex_at(const VertexBufferView& step, std::size_t index) {
  Vec3f position;
  std::memcpy(&position, static_cast<const char*>(step.data) + index * step.stride, sizeof(position));
  return position;
}

bool is_finite(const Vec3f& p) {
  return std::fabs(p.x) < kMaxCoordinate && std::fabs(p.y) < kMaxCoordinate &&
         std::fabs(p.z) < kMaxCoordinate;
}

void include(Box3f& box, const Vec3f& p) {
  box.lower = {std::min(box.lower.x, p.x), std::min(box.lower.y, p.y), std::min(box.lower.z, p.z)};
  box.upper = {std::max(box.upper.x, p.x), std::max(box.upper.y, p.y), std::max(box.upper.z, p.z)};
}

void include(Box3f& box, const Box3f& other) {
  const Vec3f &l = other.lower, &u = other.upper;
  box.lower = {std::min(box.lower.x, l.x), std::min(box.lower.y, l.y), std::min(box.lower.z, l.z)};
  box.upper = {std::max(box.upper.x, u.x), std::max(box.upper.y, u.y), std::max(box.upper.z, u.z)};
}

void mark_finite(const MeshView& mesh, std::vector<std::uint8_t>& vertices) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), kGrain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const bool finite =
          std::all_of(mesh.steps.begin(), mesh.steps.end(),
                      [&](const VertexBufferView& step) { return is_finite(vertex_at(step, i)); });
      vertices[i] = finite ? kFinite : 0;
    }
  });
}

void mark_used(const MeshView& mesh, std::vector<std::uint8_t>& vertices) {
  const auto state = [&](std::uint32_t i) { return std::atomic_ref<std::uint8_t>(vertices[i]); };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.triangle_count, kGrain), [&](const auto& range) {
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      std::array<std::uint32_t, 3> indices;
      std::memcpy(indices.data(), static_cast<const char*>(mesh.indices) + t * mesh.index_stride,
                  sizeof(indices));
      const bool valid = std::all_of(indices.begin(), indices.end(), [&](std::uint32_t i) {
        return i < vertices.size() && state(i).load(std::memory_order_relaxed) != 0;
      });
      if (!valid) continue;
      for (const std::uint32_t i : indices) state(i).store(kFinite | kUsed, std::memory_order_relaxed);
    }
  });
}

Box3f used_bounds(const VertexBufferView& step, const std::vector<std::uint8_t>& vertices) {
  // Boxes of fixed blocks, so that the union does not depend on the threads (it could in the sign of a zero).
  std::vector<Box3f> blocks((vertices.size() + kGrain - 1) / kGrain, Box3f::empty());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const std::size_t end = std::min(vertices.size(), (block + 1) * kGrain);
    for (std::size_t i = block * kGrain; i < end; ++i) {
      if ((vertices[i] & kUsed) != 0) include(blocks[block], vertex_at(step, i));
    }
  });
  Box3f box = Box3f::empty();
  for (const Box3f& block : blocks) include(box, block);
  return box;
}

}  // namespace

std::vector<Box3f> step_bounds(const MeshView& mesh,
                               const std::function<bool(std::ptrdiff_t)>& temporary_memory) {
  const std::size_t vertex_count = mesh.triangle_count == 0 ? 0 : mesh.steps[0].count;
  const auto scratch_bytes = static_cast<std::ptrdiff_t>(vertex_count);
  if (!temporary_memory(scratch_bytes)) throw std::bad_alloc();
  std::vector<std::uint8_t> vertices(vertex_count);
  mark_finite(mesh, vertices);
  mark_used(mesh, vertices);
  std::vector<Box3f> boxes;
  for (const VertexBufferView& step : mesh.steps) boxes.push_back(used_bounds(step, vertices));
  temporary_memory(-scratch_bytes);
  return boxes;
}

}  // namespace stbvh::plugin
