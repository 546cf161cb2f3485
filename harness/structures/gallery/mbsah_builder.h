/// What `stbvh-paper`, `stbvh-gated` and one ablation have in common: the motion blur surface area heuristic
/// of the paper, which counts primitive segments (Woop et al. 2017, section 3.3). Costs are in expected area,
/// SA' * T, with C_I = 1.
#pragma once

#include <optional>

#include "harness/structures/gallery/top_down.h"

namespace stbvh::harness::gallery {

class MbsahBuilder : public TopDown {
 public:
  using TopDown::TopDown;

 protected:
  struct TemporalCost {
    TimeHalves halves;
    double cost;  ///< without C_T
  };

  double leaf_cost(const ReferenceSet& set) const;
  /// The best of 32 bins in three axes, and what it costs without C_T.
  std::pair<ObjectSplit, double> object_split(const ReferenceSet& set) const;
  /// The only candidate is the step boundary nearest to the centre; none: one segment covers the range.
  std::optional<TemporalCost> temporal_split(const ReferenceSet& set) const;

  std::pair<ReferenceSet, ReferenceSet> split_in_space(ReferenceSet& set,
                                                       const ObjectSplit& split) const override;
};

}  // namespace stbvh::harness::gallery
