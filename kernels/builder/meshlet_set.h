/// The triangles of a mesh in small connected groups, made once, before the tree. A leaf holds one meshlet
/// over its time range, so the tree is built over meshlets: a fifth of the references of triangles, and
/// leaves that are nearly full (docs/algorithm.md).
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "builder/build_memory.h"
#include "builder/build_mesh.h"
#include "layout/meshlet.h"

namespace stbvh {

struct BuildContext;

/// The meshlets of one mesh.
struct MeshletSet {
  std::unique_ptr<TemporaryArray<Meshlet>> storage;  ///< null: there are none
  std::size_t triangles = 0;                         ///< in all of them: the valid ones
  std::size_t invalid_triangles = 0;                 ///< left out

  std::span<const Meshlet> meshlets() const {
    return storage == nullptr ? std::span<const Meshlet>() : storage->span();
  }
};

/// Groups the valid triangles of `mesh`. Triangles join along shared vertices; vertices that differ in index
/// but not in position, at any step, count as one. The same meshlets for any number of threads.
MeshletSet make_meshlets(BuildContext& context, const BuildMesh& mesh);
/// Those of all meshes of a build.
void make_meshlets(BuildContext& context);

}  // namespace stbvh
