/// Our structure called without Embree, so that the cost of the plugin shows.
#pragma once

#include <memory>

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

class StbvhDirect final : public StructureUnderTest {
 public:
  StbvhDirect(const Scene& scene, const BuildSettings& settings, unsigned threads);

  const BuildRecord& build_record() const override { return record_; }
  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override;

 private:
  std::unique_ptr<Structure> structure_;
  BuildRecord record_;
};

}  // namespace stbvh::harness
