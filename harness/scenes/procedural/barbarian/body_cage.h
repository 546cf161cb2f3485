/// Bodies as subdivision surfaces: a coarse cage of quads follows the skeleton, and is refined in each step.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "harness/scenes/procedural/shared/skeleton.h"

namespace stbvh::harness {

struct BodyCage {
  SkinnedShape skinned;  ///< each two triangles (a, b, c) and (a, c, d) are the quad (a, b, c, d)
  unsigned level = 0;    ///< how often it is to be refined
};

/// A cage whose limit surface meets that of `body` at every vertex, for about `triangles` triangles once it
/// is refined: twice, or less often where the cage would be too coarse for the body.
BodyCage make_body_cage(const ImplicitBody& body, const Skeleton& skeleton, std::size_t triangles);

/// A refined cage at rest and in motion: vertex i is the same one in both.
struct RefinedBody {
  VertexBuffer rest;
  Mesh moving;

  /// The triangles for which choose(centroid at rest) is true, with only their vertices.
  Mesh select(std::string name, Vec3f color, const std::function<bool(Vec3)>& choose) const;
};

/// The surface over the steps of `transforms`: the cage is skinned, then refined.
RefinedBody refine_body(const BodyCage& cage, const std::vector<std::vector<Rigid>>& transforms);

}  // namespace stbvh::harness
