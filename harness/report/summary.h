/// What a run says over all of its scenes.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "harness/report/records.h"

namespace stbvh::harness {

/// Each structure against `embree`, `embree-4v`, `lbvh` and `lbvh-4v`, where they are in the run: speed for
/// each thread count and kind of rays, and over bounce, uniform and shadow together where all three were
/// traced (a scene's ratio is then their geometric mean); bytes without and with the scene's buffers; build
/// time.
///
/// The geometric mean over the scenes is taken in each repeat, then the median, the least and the largest of
/// those means. The worst scene is the one with the least speed, or with the largest bytes or time, by the
/// median of its own repeats. Scenes that lack the structure or the reference do not count. Empty for fewer
/// than two scenes.
std::vector<SummaryResult> summarize_scenes(const Report& report);

/// The same against `references`, of one scene too. Speeds are compared by way of `embree`, which must be in
/// the run.
std::vector<SummaryResult> summarize_scenes(const Report& report,
                                            std::span<const std::string_view> references);

}  // namespace stbvh::harness
