/// What every part of one build shares: the meshes, its memory, progress and cancellation.
#pragma once

#include <cstddef>
#include <vector>

#include "builder/build_memory.h"
#include "builder/build_mesh.h"
#include "builder/build_progress.h"
#include "builder/byte_price.h"
#include "builder/meshlet_set.h"
#include "stbvh/structure.h"

namespace stbvh {

struct BuildContext {
  BuildContext(const BuildSettings& all_settings, const BuildCallbacks& callbacks)
      : settings(all_settings), memory(callbacks, settings.max_peak_bytes), progress(callbacks) {}

  BuildSettings settings;
  BuildMemory memory;  ///< before what is counted in it
  std::vector<BuildMesh> meshes;
  std::vector<MeshletSet> meshlets;  ///< of each mesh
  BuildProgress progress;
  BytePrice price;  ///< of memory
};

}  // namespace stbvh
