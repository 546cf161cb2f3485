/// One ray at a time: closest hit and any hit, with and without filter and counters.
#pragma once

#include "traverse/steps.inl"

namespace stbvh {
namespace {

/// A ray alone waits for memory most of the time: what comes next is asked for as soon as it is known, and
/// what comes after it.
struct PrefetchAhead {
  /// Also the later steps of a long leaf, or the start of the child that stands behind it.
  static void next(const StructureView& structure, Link link) { prefetch<640>(structure, link); }
  static void after_next(const StructureView& structure, Link link) {
    prefetch<sizeof(LinearNode)>(structure, link);
  }
  /// Has been asked for as what came after next.
  static void popped(const StructureView&, Link) {}
};

/// Flattened, or the compiler leaves calls in the loop where there are many loops in one source: a sixth of
/// its speed.
template <typename Test, typename Cursor, bool kFiltered, bool kCounted>
[[gnu::flatten]] bool trace_ray(const StructureView& structure, const Query& query) {
  TraversalRay ray;
  if (structure.empty || !setup_ray<Test>(structure, query.ray, ray)) return false;
  const KeptSlabs slabs(ray);
  typename Cursor::Entry stack[Cursor::kStack];
  Cursor cursor;
  cursor.start(structure, ray, stack);
  while (
      cursor.template step<Test, kFiltered, kCounted, PrefetchAhead>(structure, query, ray, slabs, stack)) {
  }
  return cursor.found;
}

}  // namespace
}  // namespace stbvh
