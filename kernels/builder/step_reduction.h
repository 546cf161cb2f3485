/// Which steps of a mesh say something: those between which its motion is not what the others say.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "stbvh/mesh_view.h"

namespace stbvh {

/// Time of a step, rounded once; a denormal one counts as 0.
float step_time(const MeshView& mesh, std::size_t step);

struct StepReduction {
  std::vector<std::size_t> kept;  ///< ascending, the first and the last among them; one: it stands still
  double deviation = 0.0;         ///< of a vertex that counts, at any time, at most
};

/// The steps of `mesh`, which has several, that keep each vertex for which `counts` holds within `tolerance`
/// of where the mesh says, at all times, or within rounding: as far as straight motion is off whose positions
/// were rounded to floats. Both motions are linear between steps, so they are furthest apart at one. From
/// each step on the longest stretch is looked for by doubling and halving; not always the fewest that are
/// possible. One step is kept where a mesh that stands still is alive in all of [0, 1], for then it is hit at
/// all times.
StepReduction reduce_steps(const MeshView& mesh, const std::function<bool(std::size_t vertex)>& counts,
                           float tolerance);

}  // namespace stbvh
