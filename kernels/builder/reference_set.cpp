#include "builder/reference_set.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace stbvh {

namespace {

constexpr std::size_t kParallelReferences = 32768;

/// Extends the bounds of `set` by those of `references`.
void extend(ReferenceSet& set, std::span<const Reference> references) {
  for (const Reference& reference : references) {
    const LinearBounds bounds = reference.bounds();
    set.bounds.extend(bounds);
    set.centroids4.extend(bounds.centroid4());
  }
}

}  // namespace

void ReferenceSet::update_bounds() {
  using Range = tbb::blocked_range<std::size_t>;
  bounds = LinearBounds::empty();
  centroids4 = Box4::empty();
  if (size() < kParallelReferences) return extend(*this, references);
  *this = tbb::parallel_reduce(
      Range(0, size(), kParallelReferences / 4), *this,
      [&](const Range& part, ReferenceSet set) {
        extend(set, references.subspan(part.begin(), part.size()));
        return set;
      },
      [](ReferenceSet a, const ReferenceSet& b) {
        a.bounds.extend(b.bounds);
        a.centroids4.extend(b.centroids4);
        return a;
      });
}

std::pair<ReferenceSet, ReferenceSet> ReferenceSet::split_at(std::size_t count) const {
  ReferenceSet left, right;
  left.references = references.first(count);
  right.references = references.subspan(count);
  left.range = right.range = range;
  left.update_bounds();
  right.update_bounds();
  return {left, right};
}

}  // namespace stbvh
