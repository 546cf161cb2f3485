/// What the builder's contract (stbvh/structure.h, stbvh/mesh_view.h) says of a mesh description, evaluated
/// one triangle at a time: the oracle of fuzz_build.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stbvh/structure.h"

namespace stbvh::fuzz {

/// Whether build() takes the description, or must throw InvalidMesh.
bool is_readable(const MeshView& mesh);

/// The triangles of a readable mesh whose vertices exist and are finite and small enough in all steps.
std::vector<std::array<std::uint32_t, 3>> valid_triangles(const MeshView& mesh);

/// Whether there is a time in [0, 1] at which the mesh can be hit.
bool is_ever_alive(const MeshView& mesh);

/// Aborts unless the statistics are those of the meshes built with `tolerance`, and agree with each other.
void check_statistics(std::span<const MeshView> meshes, float tolerance, const BuildStatistics& statistics);

/// Aborts unless all valid triangles lie in the structure's bounds at `time`, within the rounding that steps
/// are left out for.
void check_bounds(std::span<const MeshView> meshes, const Structure& structure, float time);

}  // namespace stbvh::fuzz
