/// A set of references over one time range: what the builder splits.
#pragma once

#include <span>
#include <utility>

#include "builder/reference.h"
#include "layout/closed_time_range.h"

namespace stbvh {

struct ReferenceSet {
  std::span<Reference> references;
  ClosedTimeRange range{};
  LinearBounds bounds = LinearBounds::empty();
  Box4 centroids4 = Box4::empty();  ///< of LinearBounds::centroid4()

  std::size_t size() const { return references.size(); }

  /// Makes the bounds those of all references.
  void update_bounds();
  /// The first `count` references and the others, over the same range, with their bounds.
  std::pair<ReferenceSet, ReferenceSet> split_at(std::size_t count) const;
};

}  // namespace stbvh
