/// Object splits: the best of 32 bins in each of three axes (an exact sweep for small sets).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "builder/reference_set.h"

namespace stbvh {

struct ObjectSplit {
  /// Sum over both sides of SA' * references; infinity where no plane separates the set.
  float cost = std::numeric_limits<float>::infinity();
  int axis = 0;
  /// Binned: references of bins below go left. Swept: this many go left, in the order of centroids.
  std::size_t position = 0;
};

/// Sets up to this size are swept exactly.
inline constexpr std::size_t kSweepLimit = 16;
inline constexpr std::size_t kObjectBins = 32;

ObjectSplit find_object_split(const ReferenceSet& set);

using SweepOrder = std::array<std::uint8_t, kSweepLimit>;
/// Order of up to kSweepLimit references by centroid along `axis`; ties keep their places.
SweepOrder sorted_order(std::span<const Reference> references, int axis);

/// Brings the references into the split's order; returns how many go left. Where the split separates nothing
/// (cost infinity) it is half of them, as they stand.
std::size_t partition_references(ReferenceSet& set, const ObjectSplit& split);

/// Its two sides, bounds included.
std::pair<ReferenceSet, ReferenceSet> apply_object_split(ReferenceSet& set, const ObjectSplit& split);

}  // namespace stbvh
