/// Two times at which the size of a meshlet is measured.
#pragma once

#include <array>
#include <cstddef>

#include "builder/build_mesh.h"

namespace stbvh {

inline constexpr std::size_t kSamples = 2;

inline std::array<std::size_t, kSamples> sampled_steps(const BuildMesh& mesh) {
  const std::size_t segments = mesh.segments();
  return {segments / 3, (2 * segments + 2) / 3};
}

}  // namespace stbvh
