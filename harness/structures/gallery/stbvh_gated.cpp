/// `stbvh-gated`: `stbvh-paper` with the gates that Embree puts before temporal splits (3.13.5 to 4.4.1; read
/// there).
///
/// Stored, traversed: as `stbvh-paper`. Built: a temporal split is tried only where the object split costs at
/// least half as much as a leaf, and where the set's time range is longer than 1.01 segments of its finest
/// mesh; it is taken where 1.25 times its cost is below that of the object split. One reference is a leaf,
/// over all segments of its range: Embree's leaves of shared vertices can hold several, as ours do.
///
/// Departures: those of `stbvh-paper`; Embree counts blocks of four triangles where this counts triangles.
#include <algorithm>

#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/mbsah_builder.h"

namespace stbvh::harness::gallery {
namespace {

constexpr double kTriedFrom = 0.5;
constexpr double kTemporalPenalty = 1.25;
constexpr float kLeastSegments = 1.01f;

class GatedBuilder final : public MbsahBuilder {
 public:
  using MbsahBuilder::MbsahBuilder;

 private:
  std::optional<Split> choose(const ReferenceSet& set) const override {
    if (set.size() == 1) return std::nullopt;
    const auto [object, cost] = object_split(set);
    if (cost >= kTriedFrom * leaf_cost(set) && is_longer_than_a_segment(set)) {
      const std::optional<TemporalCost> temporal = temporal_split(set);
      if (temporal && kTemporalPenalty * temporal->cost < cost) return temporal->halves;
    }
    return object;
  }

  bool is_longer_than_a_segment(const ReferenceSet& set) const {
    float segments = 0.0f;
    for (const Reference& reference : set.references) {
      segments = std::max(segments, context().meshes[reference.mesh].segments_per_time(set.range));
    }
    return set.range.length() * segments > kLeastSegments;
  }
};

}  // namespace

StructurePtr build_stbvh_gated(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_in_own_nodes<GatedBuilder>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
