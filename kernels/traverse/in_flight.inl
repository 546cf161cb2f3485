/// Many rays, several of them in flight: each does a step, asks for the memory of its next one, and the
/// others go on until that has come. One ray alone waits for it.
#pragma once

#include <cstddef>

#include "traverse/steps.inl"

namespace stbvh {
namespace {

/// Measured: 4 to 16 (docs/performance.md).
inline constexpr std::size_t kRaysInFlight = 8;

struct PrefetchNext {
  static void next(const StructureView& structure, Link link) {
    prefetch<sizeof(LinearNode)>(structure, link);
  }
  static void popped(const StructureView& structure, Link link) { next(structure, link); }
  static void after_next(const StructureView&, Link) {}
};

/// A ray in flight.
template <typename Cursor>
struct Flight {
  const Ray* query;
  TraversalRay ray;
  Cursor cursor;
  Hit hit;
  typename Cursor::Entry stack[Cursor::kStack];

  template <typename Test>
  bool start(const StructureView& structure, const Ray& next) {
    query = &next;
    if (!setup_ray<Test>(structure, next, ray)) return false;
    cursor.start(structure, ray, stack);
    return true;
  }

  template <typename Test, bool kFiltered>
  bool step(const StructureView& structure, const HitFilter* filter) {
    Cursor moved = cursor;  // in registers
    const bool goes_on = moved.template step<Test, kFiltered, false, PrefetchNext>(
        structure, {*query, &hit, filter, nullptr}, ray, BroadcastSlabs(ray), stack);
    cursor = moved;
    return goes_on;
  }
};

template <typename Test, typename Cursor, bool kFiltered>
[[gnu::flatten]] void trace_in_flight(const StructureView& structure, const RayBatch& batch) {
  Flight<Cursor> places[kRaysInFlight];
  Flight<Cursor>* flights[kRaysInFlight];
  std::size_t count = 0, next = 0;
  const auto start = [&](Flight<Cursor>* flight) {
    while (next < batch.count) {
      if (flight->template start<Test>(structure, ray_at(batch, next++))) return true;
    }
    return false;
  };
  for (Flight<Cursor>& place : places) {
    if (!start(&place)) break;
    flights[count++] = &place;
  }
  for (std::size_t i = 0; count > 0; i = i < count ? i : 0) {
    Flight<Cursor>* const flight = flights[i];
    if (!flight->template step<Test, kFiltered>(structure, batch.filter)) {
      if (flight->cursor.found && batch.report != nullptr)
        batch.report(batch.user, *flight->query, flight->hit);
      if (!start(flight)) {
        flights[i] = flights[--count];
        continue;
      }
    }
    ++i;
  }
}

template <typename Test, typename Cursor>
void trace_in_flight(const StructureView& structure, const RayBatch& batch) {
  if (structure.empty) return;
  batch.filter == nullptr ? trace_in_flight<Test, Cursor, false>(structure, batch)
                          : trace_in_flight<Test, Cursor, true>(structure, batch);
}

}  // namespace
}  // namespace stbvh
