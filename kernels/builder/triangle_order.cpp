#include "builder/triangle_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "builder/build_context.h"
#include "builder/sampled_steps.h"

namespace stbvh {

namespace {

constexpr std::size_t kChunk = 8192;

/// The lower 21 bits of `x`, two zeros between each two.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1F00000000FFFFu;
  x = (x | x << 16) & 0x1F0000FF0000FFu;
  x = (x | x << 8) & 0x100F00F00F00F00Fu;
  x = (x | x << 4) & 0x10C30C30C30C30C3u;
  x = (x | x << 2) & 0x1249249249249249u;
  return x;
}

}  // namespace

TriangleOrder::TriangleOrder(BuildContext& context, const BuildMesh& mesh)
    : mesh_(mesh), step_(sampled_steps(mesh)[0]), storage_(context.memory, mesh.triangle_count()) {
  collect_valid();
  context.progress.check();
  set_keys();
  tbb::parallel_sort(triangles_.begin(), triangles_.end());
  context.progress.check();
}

F32x4 TriangleOrder::centroid3(std::uint32_t prim) const {
  const TriangleIndices t = mesh_.triangle(prim);
  return F32x4(mesh_.position(step_, t[0])) + F32x4(mesh_.position(step_, t[1])) +
         F32x4(mesh_.position(step_, t[2]));
}

void TriangleOrder::collect_valid() {
  struct Chunk {
    std::size_t count = 0;
    Box4 centroids3 = Box4::empty();
  };
  const std::size_t count = mesh_.triangle_count();
  std::vector<Chunk> chunks((count + kChunk - 1) / kChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) {
    Chunk chunk;
    for (std::size_t k = i * kChunk; k < std::min((i + 1) * kChunk, count); ++k) {
      const std::uint32_t prim = mesh_.prim(k);
      if (!mesh_.is_valid(mesh_.triangle(prim))) continue;
      chunk.centroids3.extend(centroid3(prim));
      storage_.data()[i * kChunk + chunk.count++].prim = prim;
    }
    chunks[i] = chunk;
  });
  std::size_t valid = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    std::memmove(storage_.data() + valid, storage_.data() + i * kChunk,
                 chunks[i].count * sizeof(SortedTriangle));
    valid += chunks[i].count;
    centroids3_.extend(chunks[i].centroids3);
  }
  triangles_ = storage_.span().first(valid);
}

void TriangleOrder::set_keys() {
  const F32x4 extent = centroids3_.upper - centroids3_.lower;
  const float scale = 0x1.FFFFp20f / std::max({extent[0], extent[1], extent[2]});
  const F32x4 scale4(std::isfinite(scale) ? scale : 0.0f);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles_.size(), kChunk), [&](const auto& part) {
    for (std::size_t i = part.begin(); i != part.end(); ++i) {
      const F32x4 c = (centroid3(triangles_[i].prim) - centroids3_.lower) * scale4;
      std::uint64_t key = 0;
      for (int axis = 0; axis < 3; ++axis) key |= spread(static_cast<std::uint64_t>(c[axis])) << axis;
      triangles_[i].key = key;
    }
  });
}

}  // namespace stbvh
