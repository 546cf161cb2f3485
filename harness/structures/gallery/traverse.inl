/// The traversal of nodes that are not the kernels': theirs in all but the test of a node. A method has a
/// class of slabs, made once for each ray, and an intersect_any_node() that takes it.
#pragma once

#include "harness/structures/gallery/gallery_view.h"
#include "traverse/one_ray.inl"

namespace stbvh::harness::gallery {
namespace {

template <typename Slabs, typename Cursor, bool kCounted>
[[gnu::flatten]] bool trace_ray(const StructureView& structure, const Query& query) {
  TraversalRay ray;
  if (structure.empty || !setup_ray<WatertightTest>(structure, query.ray, ray)) return false;
  const Slabs slabs(static_cast<const GalleryView&>(structure), ray);
  typename Cursor::Entry stack[Cursor::kStack];
  Cursor cursor;
  cursor.start(structure, ray, stack);
  while (cursor.template step<WatertightTest, false, kCounted, PrefetchAhead>(structure, query, ray, slabs,
                                                                              stack)) {
  }
  return cursor.found;
}

template <typename Slabs>
constexpr GalleryKernels make_kernels() {
  return {
      [](const StructureView& s, const Ray& ray, Hit& hit) {
        return trace_ray<Slabs, ClosestHitCursor, false>(s, {ray, &hit, nullptr, nullptr});
      },
      [](const StructureView& s, const Ray& ray, Hit& hit, TraversalCounters& counters) {
        return trace_ray<Slabs, ClosestHitCursor, true>(s, {ray, &hit, nullptr, &counters});
      },
      [](const StructureView& s, const Ray& ray) {
        return trace_ray<Slabs, AnyHitCursor, false>(s, {ray, nullptr, nullptr, nullptr});
      },
  };
}

}  // namespace
}  // namespace stbvh::harness::gallery
