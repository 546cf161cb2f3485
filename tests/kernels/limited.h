/// Structures of limited memory.
#pragma once

#include <cstddef>
#include <span>

#include "stbvh/structure.h"

namespace stbvh::test {

/// Bytes of the smallest structure over `meshes`.
inline std::size_t smallest_bytes(std::span<const MeshView> meshes, BuildSettings settings = {}) {
  settings.max_bytes = 0;
  try {
    return Structure::build(meshes, settings)->statistics().structure_bytes;
  } catch (const MemoryLimit& limit) {
    return limit.needed_bytes;
  }
}

/// `settings` with `share` of the memory that the structure would take beyond the smallest.
inline BuildSettings limited(std::span<const MeshView> meshes, float share, BuildSettings settings = {}) {
  if (share >= 1.0f) return settings;
  const std::size_t least = smallest_bytes(meshes, settings);
  const std::size_t most = Structure::build(meshes, settings)->statistics().structure_bytes;
  settings.max_bytes = least + static_cast<std::size_t>(share * static_cast<float>(most - least));
  return settings;
}

}  // namespace stbvh::test
