/// Many rays of a structure that answers one at a time.
#pragma once

#include <cstddef>
#include <span>

#include "harness/structures/hit_record.h"

namespace stbvh::harness::gallery {

template <typename Structure>
void intersect_one_by_one(const Structure& structure, std::span<const Ray> rays, std::span<HitRecord> hits) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Hit hit;
    hits[i] = structure.intersect_one(rays[i], hit) ? HitRecord{hit.t, hit.geom_id, hit.prim_id}
                                                    : HitRecord{rays[i].tfar, kInvalidId, kInvalidId};
  }
}

template <typename Structure>
void occluded_one_by_one(const Structure& structure, std::span<const Ray> rays, std::span<HitRecord> hits) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::uint32_t id = structure.occluded_one(rays[i]) ? 0u : kInvalidId;
    hits[i] = {rays[i].tfar, id, id};
  }
}

}  // namespace stbvh::harness::gallery
