/// Tracing ray sets, timed and untimed.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "harness/program/pinned_threads.h"
#include "harness/rays/ray_set.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// Traces `rays` in one fixed slice for each thread; returns the seconds.
double trace(PinnedThreads& threads, const StructureUnderTest& structure, const RaySet& rays,
             std::span<HitRecord> hits);

struct TraceTimes {
  std::vector<std::vector<double>> seconds;  ///< of each structure: of each repeat
  std::vector<std::size_t> hits;             ///< of each structure
};

/// Traces the same rays with all structures in turn (A B C, B C A, ...), `repeats` times after one turn to
/// warm up. `on_repeat` is told the number of each turn.
TraceTimes trace_interleaved(PinnedThreads& threads, std::span<const StructureUnderTest* const> structures,
                             const RaySet& rays, std::size_t repeats,
                             const std::function<void(std::size_t)>& on_repeat);

/// Of the same rays: how many hit something in one answer alone, or elsewhere by more than `far_off` of the
/// distance. Triangles at the same distance are either's.
std::size_t count_differing(std::span<const HitRecord> a, std::span<const HitRecord> b, double far_off);

}  // namespace stbvh::harness
