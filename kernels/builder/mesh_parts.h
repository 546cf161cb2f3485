/// Parts of a mesh that do not need all of its steps: what stands still in what moves, for example.
#pragma once

#include <cstddef>

#include "stbvh/mesh_view.h"

namespace stbvh {

struct BuildContext;

/// Adds the mesh of number `index` to `context.meshes` as it is built: whole, or in parts. A part consists of
/// connected components of the mesh, those that need the same steps; vertices at the same place at a kept
/// step are connected, so that no border opens between parts. Each keeps some of the steps that the whole
/// would keep, as many as stay within the tolerance (reduce_steps()). Throws as BuildMesh does,
/// BuildCancelled, and BuildMemory::LimitReached.
void add_mesh(BuildContext& context, const MeshView& view, std::size_t index);

}  // namespace stbvh
