/// Object splits: the best of 32 bins in each of three axes (an exact sweep for small sets).
#pragma once

#include <cstddef>
#include <limits>
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

/// Reorders the references of `set` and returns its two sides, bounds included. Where the split separates
/// nothing (cost infinity) the set is cut in two halves as it stands.
std::pair<ReferenceSet, ReferenceSet> apply_object_split(ReferenceSet& set, const ObjectSplit& split);

}  // namespace stbvh
