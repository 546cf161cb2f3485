/// Meshlets: the triangles of a mesh in small connected groups, made once, before the tree. A leaf holds one
/// meshlet over its time range, so the tree is built over meshlets: a fifth of the references of triangles,
/// and leaves that are nearly full (docs/algorithm.md).
#pragma once

#include "builder/build_context.h"
#include "builder/meshlet.h"

namespace stbvh {

/// Groups the valid triangles of `mesh`. Triangles join along shared vertices; vertices that differ in index
/// but not in position, at any step, count as one. The same meshlets for any number of threads.
MeshletSet make_meshlets(BuildContext& context, const BuildMesh& mesh);

}  // namespace stbvh
