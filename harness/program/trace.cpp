#include "harness/program/trace.h"

#include <algorithm>
#include <cmath>

namespace stbvh::harness {

double trace(PinnedThreads& threads, const StructureUnderTest& structure, const RaySet& rays,
             std::span<HitRecord> hits) {
  const std::size_t n = rays.rays.size();
  return threads.run([&](unsigned thread) {
    const std::size_t begin = n * thread / threads.count();
    const std::size_t size = n * (thread + 1) / threads.count() - begin;
    const std::span<const Ray> slice = std::span(rays.rays).subspan(begin, size);
    if (rays.any_hit()) {
      structure.occluded(slice, hits.subspan(begin, size));
    } else {
      structure.intersect(slice, hits.subspan(begin, size));
    }
  });
}

TraceTimes trace_interleaved(PinnedThreads& threads, std::span<const StructureUnderTest* const> structures,
                             const RaySet& rays, std::size_t repeats,
                             const std::function<void(std::size_t)>& on_repeat) {
  const std::size_t n = structures.size();
  TraceTimes times{std::vector<std::vector<double>>(n), std::vector<std::size_t>(n)};
  std::vector<HitRecord> hits(rays.rays.size());
  for (std::size_t repeat = 0; repeat <= repeats; ++repeat) {
    on_repeat(repeat);
    for (std::size_t turn = 0; turn < n; ++turn) {
      const std::size_t s = (turn + repeat) % n;
      const double seconds = trace(threads, *structures[s], rays, hits);
      if (repeat > 0) times.seconds[s].push_back(seconds);
      times.hits[s] = static_cast<std::size_t>(
          std::count_if(hits.begin(), hits.end(), [](const HitRecord& hit) { return hit.is_hit(); }));
    }
  }
  return times;
}

std::size_t count_differing(std::span<const HitRecord> a, std::span<const HitRecord> b, double far_off) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const bool both = a[i].is_hit() && b[i].is_hit();
    const bool same =
        both ? std::fabs(a[i].t - b[i].t) <= far_off * std::fabs(b[i].t) : a[i].is_hit() == b[i].is_hit();
    count += same ? 0u : 1u;
  }
  return count;
}

}  // namespace stbvh::harness
