/// What the structures of the gallery see at a time: the bounds of a turning bar.
#pragma once

#include <string>
#include <vector>

#include "harness/program/progress.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// The triangles of the bar at some times, then the bounds of each of `names` that can show them.
std::vector<SliceResult> slices_of(const std::vector<std::string>& names, Progress& progress);

}  // namespace stbvh::harness
