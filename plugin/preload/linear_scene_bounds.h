/// The box of meshes that rtcGetSceneLinearBounds and instances show.
#pragma once

#include <span>
#include <vector>

#include "stbvh/mesh_view.h"

namespace stbvh::preload {

/// A box that moves linearly over the ray times [0, 1].
struct LinearBox {
  Box3f begin = Box3f::empty();
  Box3f end = Box3f::empty();

  void extend(const LinearBox& other);
  bool is_empty() const { return !(begin.lower.x <= begin.upper.x); }
};

/// Of each mesh the union, corner by corner at both ends, of the linear bounds of its valid triangles over
/// [0, 1]; empty without any, and if the mesh is alive in nothing or next to nothing of [0, 1]. On all
/// threads.
///
/// The linear bounds of a triangle are those of Woop et al. 2017, section 3.2: the boxes at the ends, both
/// shifted outwards wherever a box between them sticks out. Computed in float, in the order in which Embree
/// 3.13 does: the scene's bounds are then the same numbers as with Embree's own triangles. Exceptions:
/// docs/preload.md.
std::vector<LinearBox> linear_bounds_of(std::span<const MeshView* const> meshes);

}  // namespace stbvh::preload
