/// What a command says on one screen: a line for each structure. The whole tables: table.h.
#pragma once

#include <string>
#include <vector>

#include "harness/report/records.h"

namespace stbvh::harness {

/// Speed, bytes and build time against `embree` over all scenes, a block for each thread count. Empty for
/// fewer than two scenes, or without `embree`.
std::string summary_screen(const std::vector<SummaryResult>& results);

/// Wrong answers over all scenes and kinds of rays.
std::string error_screen(const std::vector<ErrorResult>& results);

/// Wrong answers over all families, and the family with most of them.
std::string hard_screen(const std::vector<HardResult>& results);

}  // namespace stbvh::harness
