/// A refined cage, whatever its positions: which triangles it has, and how its vertices follow the cage's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "harness/scenes/subdivision/subdivision.h"

namespace stbvh::harness::subdivision {

/// A sparse matrix: row r is a weighted sum of the columns from first[r] on. The first rows may be used by
/// the others: column c below `own` is row c, and c above is the element c - own of what the matrix is
/// applied to.
struct WeightedSums {
  std::size_t own = 0;
  std::vector<std::size_t> first{0};  ///< one more than there are rows
  std::vector<std::uint32_t> columns;
  std::vector<double> weights;

  std::size_t size() const { return first.size() - 1; }
};

struct CageTopology {
  /// Each level's vertices by those of the level before, from the cage's on; last the limits of those that
  /// the mesh has. By levels, since a stencil over all of them grows with the valence of each vertex that is
  /// near: they would need time and memory by its square.
  std::vector<WeightedSums> stages;
  std::vector<std::uint32_t> indices;  ///< 3 for each triangle
  std::vector<std::uint32_t> faces;    ///< of each triangle the cage's face
};

/// The faces of the level, before holes are taken out.
std::size_t refined_face_count(const SubdivisionCage& cage, unsigned level);

/// For a cage that check_cage() took. Throws std::invalid_argument where OpenSubdiv cannot take it, and
/// InvisibleCage where no face is left.
CageTopology refine_topology(const SubdivisionCage& cage, unsigned level);

}  // namespace stbvh::harness::subdivision
