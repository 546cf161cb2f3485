#include "builder/make_references.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "builder/motion_bounds.h"

namespace stbvh {

namespace {

constexpr std::size_t kChunk = 1024;

ClosedTimeRange times_of(const std::vector<BuildMesh>& meshes) {
  ClosedTimeRange range{1.0f, 0.0f};
  for (const BuildMesh& mesh : meshes) {
    range.begin = std::min(range.begin, std::max(mesh.grid().begin, 0.0f));
    range.last = std::max(range.last, std::min(mesh.grid().end, 1.0f));
  }
  if (range.begin > range.last) return {0.0f, 0.0f};  // nothing is ever alive
  return range;
}

}  // namespace

ReferenceSet make_references(BuildContext& context, std::span<Reference> storage) {
  ReferenceSet set;
  set.range = times_of(context.meshes);
  std::size_t out = 0;
  for (std::size_t m = 0; m < context.meshes.size(); ++m) {
    const BuildMesh& mesh = context.meshes[m];
    const std::span<const Meshlet> meshlets = context.meshlets[m].meshlets();
    const MotionSamples samples(mesh, set.range);
    if (samples.empty()) continue;
    context.progress.poll();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, meshlets.size(), kChunk), [&](const auto& part) {
      for (std::size_t i = part.begin(); i != part.end(); ++i) {
        const LinearBounds bounds = motion_bounds(mesh, samples, meshlets[i].used_vertices());
        storage[out + i] =
            make_reference(bounds, static_cast<std::uint32_t>(m), static_cast<std::uint32_t>(i));
      }
    });
    out += meshlets.size();
  }
  set.references = storage.first(out);
  set.update_bounds();
  return set;
}

}  // namespace stbvh
