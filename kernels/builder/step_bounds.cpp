#include "builder/step_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "builder/build_context.h"
#include "simd/box4.h"

namespace stbvh {

namespace {

constexpr std::size_t kBlock = 4096;

Box4 bounds_at(const VertexBufferView& step, std::span<const Meshlet> meshlets) {
  // Boxes of fixed blocks, so that the union does not depend on the threads (it could in the sign of a zero).
  std::vector<Box4> blocks((meshlets.size() + kBlock - 1) / kBlock, Box4::empty());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const std::size_t begin = block * kBlock;
    for (const Meshlet& meshlet : meshlets.subspan(begin, std::min(kBlock, meshlets.size() - begin))) {
      for (const std::uint32_t v : meshlet.used_vertices()) blocks[block].extend(F32x4(step.position(v)));
    }
  });
  Box4 box = Box4::empty();
  for (const Box4& block : blocks) box.extend(block);
  return box;
}

}  // namespace

std::vector<Box3f> step_bounds(const BuildMesh& mesh) {
  const MeshView& view = mesh.view();
  std::vector<std::uint8_t> used(view.steps[0].count);
  for (std::size_t prim = 0; prim < view.triangle_count; ++prim) {
    const TriangleIndices triangle = view.triangle(prim);
    if (!mesh.is_valid(triangle)) continue;
    for (const std::uint32_t vertex : triangle) used[vertex] = 1;
  }
  std::vector<Box3f> boxes(view.steps.size());
  tbb::parallel_for(std::size_t{0}, boxes.size(), [&](std::size_t step) {
    Box4 box = Box4::empty();
    for (std::size_t vertex = 0; vertex < used.size(); ++vertex) {
      if (used[vertex] != 0) box.extend(F32x4(view.steps[step].position(vertex)));
    }
    boxes[step] = to_box3f(box);
  });
  return boxes;
}

std::vector<Box3f> step_bounds(const BuildMesh& mesh, std::span<const Meshlet> meshlets) {
  std::vector<Box3f> boxes;
  for (const VertexBufferView& step : mesh.view().steps) boxes.push_back(to_box3f(bounds_at(step, meshlets)));
  return boxes;
}

void tell_step_bounds(const BuildContext& context, const BuildCallbacks& callbacks) {
  for (std::size_t i = 0; callbacks.step_bounds && i < context.meshes.size(); ++i) {
    const BuildMesh& mesh = context.meshes[i];
    callbacks.step_bounds(mesh.index(), step_bounds(mesh, context.meshlets[i].meshlets()),
                          mesh.view().step_times);
  }
}

}  // namespace stbvh
