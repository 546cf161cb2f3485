/// A set of references over one time range: what the builder splits.
#pragma once

#include <span>
#include <utility>

#include "builder/reference.h"

namespace stbvh {

struct ReferenceSet {
  std::span<Reference> references;
  ClosedTimeRange range{};
  LinearBounds bounds = LinearBounds::empty();
  F32x4 centroid4_lower{std::numeric_limits<float>::infinity()};
  F32x4 centroid4_upper{-std::numeric_limits<float>::infinity()};

  std::size_t size() const { return references.size(); }

  /// Extends the bounds by one reference's.
  void extend(const Reference& reference) {
    const LinearBounds b = reference.bounds();
    bounds.extend(b);
    const F32x4 centroid4 = b.centroid4();
    centroid4_lower = min(centroid4_lower, centroid4);
    centroid4_upper = max(centroid4_upper, centroid4);
  }
  /// Makes the bounds those of all references.
  void update_bounds();
  /// The first `count` references and the others, over the same range, with their bounds.
  std::pair<ReferenceSet, ReferenceSet> split_at(std::size_t count) const;
};

}  // namespace stbvh
