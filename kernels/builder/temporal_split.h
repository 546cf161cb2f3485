/// Temporal splits: the time range cut at a step boundary near its centre, references made anew for both
/// halves with tighter linear bounds (Woop et al. 2017, section 3.2).
#pragma once

#include <array>
#include <optional>
#include <span>

#include "builder/build_context.h"
#include "builder/reference_set.h"

namespace stbvh {

struct TemporalSplit {
  std::array<ClosedTimeRange, 2> halves;  ///< together the set's range, without a float between them
  /// Share of the references whose shrinking pays for the memory of a leaf more: 0 to 1.
  float wanted_share = 0.0f;
};

/// The split at the step boundary nearest to the centre of the range, on the finest grid among the set's
/// meshes; none where that one has no step inside. Sets of more than 64 are judged by an evenly spaced sample
/// of their references.
std::optional<TemporalSplit> find_temporal_split(const BuildContext& context, const ReferenceSet& set);

/// References of `set` made anew for `range`, those not alive in it dropped; into `storage`, which holds
/// set.size().
ReferenceSet remake_references(const BuildContext& context, const ReferenceSet& set,
                               const ClosedTimeRange& range, std::span<Reference> storage);

}  // namespace stbvh
