/// A whole ray set through a structure, on the calling thread.
#pragma once

#include <vector>

#include "harness/rays/ray_set.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

inline std::vector<HitRecord> trace_all(const StructureUnderTest& structure, const RaySet& rays) {
  std::vector<HitRecord> hits(rays.rays.size());
  if (rays.any_hit()) {
    structure.occluded(rays.rays, hits);
  } else {
    structure.intersect(rays.rays, hits);
  }
  return hits;
}

}  // namespace stbvh::harness
