#include "harness/structures/gallery/mbsah_builder.h"

#include "builder/mbsah.h"
#include "builder/temporal_split.h"
#include "harness/structures/gallery/weighted_split.h"

namespace stbvh::harness::gallery {

double MbsahBuilder::leaf_cost(const ReferenceSet& set) const {
  if (set.size() == 0) return 0.0;
  return static_cast<double>(expected_area(set.bounds, set.range)) *
         static_cast<double>(segments_of(context(), set));
}

std::pair<ObjectSplit, double> MbsahBuilder::object_split(const ReferenceSet& set) const {
  const ObjectSplit split = find_weighted_split(context(), set);
  return {split, static_cast<double>(split.cost) * static_cast<double>(set.range.length())};
}

std::optional<MbsahBuilder::TemporalCost> MbsahBuilder::temporal_split(const ReferenceSet& set) const {
  const std::optional<TemporalSplit> split = find_temporal_split(context(), set);
  if (!split) return std::nullopt;
  TemporaryArray<Reference> storage(context().memory, set.size());
  double cost = 0.0;
  for (const ClosedTimeRange& half : split->halves)
    cost += leaf_cost(remake_references(context(), set, half, storage.span()));
  return TemporalCost{split->halves, cost};
}

std::pair<ReferenceSet, ReferenceSet> MbsahBuilder::split_in_space(ReferenceSet& set,
                                                                   const ObjectSplit& split) const {
  return apply_weighted_split(set, split);
}

}  // namespace stbvh::harness::gallery
