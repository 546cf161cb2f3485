/// What a ray met.
#pragma once

#include <cstdint>

#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

/// A point of a triangle at a time.
struct Surface {
  Vec3 position;
  Vec3 normal;       ///< unit, as the triangle winds; zero where the triangle has no extent
  double clearance;  ///< how far above it a ray must start to meet it neither by rounding
  double u, v;       ///< position = (1-u-v) p_0 + u p_1 + v p_2
};

/// Where `ray` meets the triangle that `hit` names, from the mesh's own vertices in double precision: so all
/// structures that name the same triangle continue a path in the same way, to the last bit. `hit` gives u and
/// v where the ray lies in the triangle's plane.
Surface surface_at(const Mesh& mesh, const Ray& ray, const Hit& hit);

/// The point (u, v) of triangle `prim`, whose indices are in range; the mesh is visible at `time`.
Surface surface_point(const Mesh& mesh, std::size_t prim, double u, double v, float time);

/// Twice the area of a triangle, along its normal.
inline Vec3 area_vector(const std::array<Vec3, 3>& p) {
  return cross(p[1] - p[0], p[2] - p[0]);
}

/// A ray to `direction` from above `surface`, on that side of it.
Ray ray_from(const Surface& surface, Vec3 direction, float time);

/// A ray that ends just before `target`: it meets neither surface.
Ray ray_between(const Surface& surface, const Surface& target, float time);

}  // namespace stbvh::harness
