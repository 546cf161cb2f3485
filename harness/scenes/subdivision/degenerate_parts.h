/// Parts of cages without a meaning, which programs that make cages leave in them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "harness/scenes/subdivision/subdivision.h"

namespace stbvh::harness {

struct DegenerateParts {
  std::size_t faces = 0;               ///< of fewer than three corners, or with a vertex twice
  std::size_t creases = 0;             ///< of edges that no face has
  std::vector<std::uint32_t> numbers;  ///< of the faces that are left: what they were before
};

/// Takes them out of the cage, as Embree overlooks them; numbers of holes follow. What refine() refuses
/// besides stays as it is.
DegenerateParts take_out_degenerate_parts(SubdivisionCage& cage);

}  // namespace stbvh::harness
