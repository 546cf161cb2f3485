/// What every part of one build shares: the meshes, its memory, progress and cancellation.
#pragma once

#include <vector>

#include "builder/build_memory.h"
#include "builder/build_mesh.h"
#include "builder/build_progress.h"
#include "builder/meshlet_set.h"
#include "stbvh/structure.h"

namespace stbvh {

struct BuildContext {
  explicit BuildContext(const BuildCallbacks& callbacks) : memory(callbacks), progress(callbacks) {}

  std::vector<BuildMesh> meshes;
  std::vector<MeshletSet> meshlets;  ///< of each mesh
  BuildSettings settings;
  BuildMemory memory;
  BuildProgress progress;
};

}  // namespace stbvh
