/// Triangles that no structure can hit, for their vertices are not finite or too far away: one rule for all
/// readers of scene files.
#pragma once

#include <filesystem>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// Takes those triangles, and the vertices that make them so, out of the scene's meshes: all coordinates in
/// all steps are finite and below kMaxCoordinate then, so that bounds, cameras and what is written are right.
/// Meshes that lose all of their triangles are gone. Tells `warn` one sentence, which names `file` and the
/// meshes, where there are any. Indices are in range.
void leave_out_invalid_triangles(Scene& scene, const std::filesystem::path& file, const SceneWarning& warn);

}  // namespace stbvh::harness
