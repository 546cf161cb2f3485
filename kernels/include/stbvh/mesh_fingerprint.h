/// Telling meshes by what their buffers hold: which have changed since a build, which are those of a saved
/// structure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stbvh/structure.h"

namespace stbvh {

/// Of 128 bits, from what it stands for.
struct ContentHash {
  std::uint64_t low = 0, high = 0;
  bool operator==(const ContentHash&) const = default;
};

/// What of a mesh decides what is built of it.
struct MeshFingerprint {
  ContentHash shape;      ///< triangles, times, counts
  ContentHash positions;  ///< of all steps

  bool operator==(const MeshFingerprint&) const = default;
};

/// Reads all buffers, on all threads.
std::vector<MeshFingerprint> fingerprints_of(std::span<const MeshView> meshes);

MeshChange change_between(const MeshFingerprint& before, const MeshFingerprint& now);

}  // namespace stbvh
