/// The methods of the gallery beside each other.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "harness/report/records.h"

namespace stbvh::harness {

/// A line for each structure over the scenes of `results`: speed, bytes and build time by `summaries`, of
/// which there is one for each reference; nodes and leaves, wrong answers, the steps that it takes.
std::string gallery_table(const std::vector<GalleryResult>& results,
                          const std::vector<SummaryResult>& summaries);

}  // namespace stbvh::harness
