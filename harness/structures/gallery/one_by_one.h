/// A structure that answers one ray at a time.
#pragma once

#include <cstddef>
#include <span>

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness::gallery {

/// `Derived`, which is final and so asked without a virtual call for each ray, answers the single ones.
template <typename Derived>
class OneByOne : public StructureUnderTest {
 public:
  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const final {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      Hit hit;
      hits[i] = derived().intersect_one(rays[i], hit) ? HitRecord{hit.t, hit.geom_id, hit.prim_id}
                                                      : HitRecord{rays[i].tfar, kInvalidId, kInvalidId};
    }
  }
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const final {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::uint32_t id = derived().occluded_one(rays[i]) ? 0u : kInvalidId;
      hits[i] = {rays[i].tfar, id, id};
    }
  }

 private:
  const Derived& derived() const { return static_cast<const Derived&>(*this); }
};

}  // namespace stbvh::harness::gallery
