/// The boxes of meshes at their steps as bytes, for files of saved structures.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "plugin/motion_grid.h"

namespace stbvh::plugin {

/// Of each mesh, by parts.
using MotionsOfMeshes = std::vector<std::vector<MeshMotion>>;

std::vector<std::byte> to_bytes(const MotionsOfMeshes& motions);

/// None where the bytes are not those of as many meshes as there are `time_ranges`.
std::optional<MotionsOfMeshes> to_motions(std::span<const std::byte> bytes,
                                          std::span<const TimeRange> time_ranges);

}  // namespace stbvh::plugin
