/// Our structure called without Embree, so that the cost of the plugin shows.
#pragma once

#include <memory>
#include <optional>

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// As BuildSettings::max_bytes: as few as may be.
inline constexpr std::size_t kSmallest = 0;

class StbvhDirect : public StructureUnderTest {
 public:
  /// Traces on the default instruction set unless `isa`, one of available_isas(), is given.
  StbvhDirect(const Scene& scene, const BuildSettings& settings, unsigned threads,
              const BuildProgress& progress, std::optional<Isa> isa = std::nullopt);

  const BuildRecord& build_record() const override { return record_; }
  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  bool intersect_one(const Ray& ray, Hit& hit) const override;
  bool occluded_one(const Ray& ray) const override;
  /// The counting traversal is that of the default instruction set.
  bool has_counters() const override { return !isa_; }
  bool intersect_one_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  std::vector<Outline> outlines_at(float time, std::size_t level) const override;
  const Structure* tree() const override { return structure_.get(); }

 private:
  std::unique_ptr<Structure> structure_;
  std::optional<Isa> isa_;
  BuildRecord record_;
};

/// The same, given all rays of a call at once; for pictures single ones.
class StbvhBatch final : public StbvhDirect {
 public:
  using StbvhDirect::StbvhDirect;

  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
};

}  // namespace stbvh::harness
