#include "builder/meshlet_set.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

#include "builder/build_context.h"
#include "builder/meshlet_grouping.h"
#include "builder/triangle_order.h"

namespace stbvh {

/// Triangles are sorted along a space-filling curve and grouped in runs of this many, each on its own.
static constexpr std::size_t kRun = 8192;

MeshletSet make_meshlets(BuildContext& context, const BuildMesh& mesh) {
  MeshletSet set;
  if (mesh.triangle_count() == 0) return set;
  const TriangleOrder order(context, mesh);
  const std::span<const SortedTriangle> triangles = order.triangles();
  set.triangles = triangles.size();
  set.invalid_triangles = mesh.triangle_count() - triangles.size();
  if (triangles.empty()) return set;

  using Array = TemporaryArray<Meshlet>;
  std::vector<std::unique_ptr<Array>> runs((triangles.size() + kRun - 1) / kRun);
  tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t i) {
    context.progress.check();
    const std::size_t begin = i * kRun;
    const std::size_t count = std::min(kRun, triangles.size() - begin);
    const CountedMemory counted(context.memory, count * MeshletGrouping::kBytesPerTriangle);
    MeshletGrouping grouping(mesh, triangles.subspan(begin, count));
    const std::vector<Meshlet> meshlets = grouping.group();
    runs[i] = std::make_unique<Array>(context.memory, meshlets.size());
    std::copy(meshlets.begin(), meshlets.end(), runs[i]->data());
  });
  for (const auto& run : runs) {
    if (run == nullptr) throw BuildCancelled();  // tasks were skipped: another mesh has thrown
  }
  if (runs.size() == 1) {
    set.storage = std::move(runs[0]);
    return set;
  }
  std::size_t count = 0;
  for (const auto& run : runs) count += run->span().size();
  set.storage = std::make_unique<Array>(context.memory, count);
  Meshlet* out = set.storage->data();
  for (auto& run : runs) {
    out = std::copy(run->span().begin(), run->span().end(), out);
    run.reset();
  }
  return set;
}

void make_meshlets(BuildContext& context) {
  context.meshlets.resize(context.meshes.size());
  tbb::parallel_for(std::size_t{0}, context.meshes.size(),
                    [&](std::size_t i) { context.meshlets[i] = make_meshlets(context, context.meshes[i]); });
}

}  // namespace stbvh
