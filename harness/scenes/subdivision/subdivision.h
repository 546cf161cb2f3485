/// Catmull-Clark and Loop surfaces: an animated cage becomes an animated mesh of triangles.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// A polygon mesh whose subdivision surface is meant; only its vertices move.
struct SubdivisionCage {
  std::vector<std::uint32_t> face_sizes;     ///< corners of each face, at least 3
  std::vector<std::uint32_t> face_vertices;  ///< corners of all faces, one after another
  std::vector<VertexBuffer> steps;           ///< cage positions, 1 to kMaxSteps, all of the same size

  enum class Scheme {
    kCatmullClark,
    kLoop,  ///< of triangles alone
  } scheme = Scheme::kCatmullClark;

  /// Sharpness 0 is smooth; each level takes 1 away; from 10 on the edge or vertex stays sharp at all levels.
  struct Crease {
    std::uint32_t a, b;
    float sharpness;
  };
  std::vector<Crease> edge_creases;
  struct Corner {
    std::uint32_t vertex;
    float sharpness;
  };
  std::vector<Corner> vertex_creases;
  std::vector<std::uint32_t> holes;  ///< faces that shape the surface, but are left out of it

  enum class Boundary {
    kNone,           ///< faces at a border only guide the surface, which ends before them
    kEdgeOnly,       ///< borders are sharp edges, their corners round
    kEdgeAndCorner,  ///< and vertices of one face are sharp corners
  } boundary = Boundary::kEdgeOnly;
};

/// Most times that a cage is refined.
inline constexpr unsigned kMaxRefinementLevel = 10;
/// Most faces of a refined cage; with their weights they take some 8 GB.
inline constexpr std::size_t kMaxRefinedFaces = std::size_t{1} << 25;
/// Most bytes of the vertices of all steps.
inline constexpr std::size_t kMaxRefinedBytes = std::size_t{24} << 30;

/// How finely a surface is cut.
struct RefinementTarget {
  unsigned level = 3;  ///< times that each face is cut in four
  /// If there is one, `level` is not used, but the least level at which all edges of all triangles are
  /// shorter in all steps.
  std::optional<float> edge_length;
};

/// A cage that is sound but shows nothing: all its faces are holes, or lie at a border that ends before them.
struct InvisibleCage : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Indices and steps of a mesh on the limit surface of the cage (Catmull and Clark 1978, creases by DeRose
/// et al. 1998), by OpenSubdiv: the same level everywhere, the same topology in all steps, each vertex at its
/// limit position (creases that are left at the last level count as sharp for ever). The refinement is worked
/// out once, and applied to the steps in parallel; the result does not depend on the number of threads.
/// Vertices that no triangle uses are left out; at level 0 the others stand in the cage's order. Throws
/// std::invalid_argument, in one sentence, for cages that are not sound and for targets beyond these limits;
/// InvisibleCage where no triangle is left.
Mesh refine(const SubdivisionCage& cage, const RefinementTarget& target);

}  // namespace stbvh::harness
