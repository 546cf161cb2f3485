/// Which meshes Embree can build over.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "harness/scenes/scene.h"

namespace stbvh::harness::embree_xml {

/// A moving mesh must be seen for this part of [0, 1], and its range be no longer than that: Debian's Embree
/// aborts the process while it builds over others.
inline constexpr float kLeastTimeSeen = 0x1p-10f, kLongestTimeRange = 16;

inline bool is_seen(const Mesh& mesh) {
  const TimeRange& range = mesh.time_range;
  const float seen = std::min(range.end, 1.0f) - std::max(range.begin, 0.0f);
  return mesh.is_static() || (seen >= kLeastTimeSeen && range.end - range.begin <= kLongestTimeRange);
}

/// The sentence that says which meshes are left out for that; empty where there are none.
inline std::string unseen_meshes(const Scene& scene) {
  std::string names;
  for (const Mesh& mesh : scene.meshes) {
    if (!is_seen(mesh)) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", mesh.name);
  }
  if (names.empty()) return {};
  return fmt::format(
      "Meshes whose time range holds less than {} of [0, 1], or is longer than {}, are left out: {}.",
      kLeastTimeSeen, kLongestTimeRange, names);
}

}  // namespace stbvh::harness::embree_xml
