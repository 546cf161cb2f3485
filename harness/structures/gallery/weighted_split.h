/// Object splits by the number of primitive segments instead of references (Woop et al. 2017, section 3.3).
#pragma once

#include <utility>

#include "builder/build_context.h"
#include "builder/object_split.h"
#include "builder/reference_set.h"

namespace stbvh::harness::gallery {

/// |X|_s: primitive segments that a meshlet has over `range`; a static one counts once.
std::size_t segments_of(const BuildContext& context, const Reference& reference,
                        const ClosedTimeRange& range);
std::size_t segments_of(const BuildContext& context, const ReferenceSet& set);

/// As find_object_split(), but that cost is the sum over both sides of SA' * segments, always of 32 bins.
ObjectSplit find_weighted_split(const BuildContext& context, const ReferenceSet& set);
/// As apply_object_split(), for these.
std::pair<ReferenceSet, ReferenceSet> apply_weighted_split(ReferenceSet& set, const ObjectSplit& split);

}  // namespace stbvh::harness::gallery
