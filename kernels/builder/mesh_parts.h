/// Parts of a mesh that do not need all of its steps: what stands still in what moves, for example.
#pragma once

#include <vector>

#include "builder/build_memory.h"
#include "builder/build_mesh.h"

namespace stbvh {

/// Adds the mesh of number `index` to `meshes` as it is built: whole, or in parts. A part consists of
/// connected components of the mesh, those that need the same steps; vertices at the same place at a kept
/// step are connected, so that no border opens between parts. Each keeps some of the steps that the whole
/// would keep, as many as stay within `tolerance` (reduce_steps()). Throws as BuildMesh does, and as
/// BuildMemory::take().
void add_mesh(std::vector<BuildMesh>& meshes, const MeshView& view, std::size_t index, float tolerance,
              BuildMemory& memory);

}  // namespace stbvh
