/// The entry points of one instruction set with one test of rays.
#pragma once

#include "traverse/in_flight.inl"
#include "traverse/kernel_table.h"
#include "traverse/one_ray.inl"

namespace stbvh {
namespace {

template <typename Test>
constexpr KernelTable make_kernel_table() {
  return {
      [](const StructureView& s, const Ray& ray, Hit& hit) {
        return trace_ray<Test, ClosestHitCursor, false, false>(s, {ray, &hit, nullptr, nullptr});
      },
      [](const StructureView& s, const Ray& ray, Hit& hit, const HitFilter& filter) {
        return trace_ray<Test, ClosestHitCursor, true, false>(s, {ray, &hit, &filter, nullptr});
      },
      [](const StructureView& s, const Ray& ray, Hit& hit, TraversalCounters& counters) {
        return trace_ray<Test, ClosestHitCursor, false, true>(s, {ray, &hit, nullptr, &counters});
      },
      trace_in_flight<Test, ClosestHitCursor>,
      [](const StructureView& s, const Ray& ray) {
        return trace_ray<Test, AnyHitCursor, false, false>(s, {ray, nullptr, nullptr, nullptr});
      },
      [](const StructureView& s, const Ray& ray, const HitFilter& filter) {
        return trace_ray<Test, AnyHitCursor, true, false>(s, {ray, nullptr, &filter, nullptr});
      },
      [](const StructureView& s, const Ray& ray, TraversalCounters& counters) {
        return trace_ray<Test, AnyHitCursor, false, true>(s, {ray, nullptr, nullptr, &counters});
      },
      trace_in_flight<Test, AnyHitCursor>,
  };
}

}  // namespace
}  // namespace stbvh
