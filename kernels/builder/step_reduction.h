/// Which steps of a mesh say something: those between which its motion is not what the others say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "stbvh/mesh_view.h"

namespace stbvh {

/// Time of a step, rounded once; a denormal one counts as 0.
float step_time(const MeshView& mesh, std::size_t step);

struct StepReduction {
  std::vector<std::size_t> kept;  ///< ascending, the first and the last among them; one: it stands still
  double deviation = 0.0;         ///< of a vertex that counts, at any time, at most
};

/// Some vertices of a mesh.
struct VertexChoice {
  std::size_t count;
  std::function<std::uint32_t(std::size_t)> vertex;  ///< kNoVertex: none
};
inline constexpr std::uint32_t kNoVertex = 0xFFFFFFFFu;

/// Those of `steps`, which are some of `mesh` and several, that keep each chosen vertex within `tolerance` of
/// where the mesh says, at all times, or within rounding: as far as straight motion is off whose positions
/// were rounded to floats. All of `steps` do. Both motions are linear between steps, so they are furthest
/// apart at one. From each step on the longest stretch is looked for by doubling and halving; not always the
/// fewest that are possible. Takes the time of reading all steps some times over. One step is kept where
/// vertices that stand still are alive in all of [0, 1], for then they are hit at all times.
StepReduction reduce_steps(const MeshView& mesh, const VertexChoice& vertices,
                           std::span<const std::size_t> steps, float tolerance);

/// How many of `steps` each of the chosen vertices, on average, could do without if its neighbours stayed, as
/// a share of them all: an estimate of what it brings to reduce vertices by themselves.
double dispensable_share(const MeshView& mesh, const VertexChoice& vertices,
                         std::span<const std::size_t> steps, float tolerance);

}  // namespace stbvh
