/// Where rays come from: a camera, the bounds of a scene, points on its geometry.
#pragma once

#include <optional>
#include <vector>

#include "harness/scenes/pcg32.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

Ray make_ray(Vec3 origin, Vec3 direction, double tfar, float time);

/// Uniform in [0, 1].
float random_time(Pcg32& random);

/// Uniform on the unit sphere.
Vec3 random_direction(Pcg32& random);

/// A point beside a surface, seen from the side of `normal` (unit).
struct SurfacePoint {
  Vec3 position;
  Vec3 normal;
  float time;
};

/// The point that `ray` hits at `t` on triangle `prim`, moved to the ray's side of the surface by `ulps`
/// units in the last place of the coordinates that made it.
SurfacePoint point_off_surface(const Mesh& mesh, std::size_t prim, const Ray& ray, double t, double ulps);

/// Pinhole camera; the image is [0, 1]^2, rows from top to bottom.
class CameraRays {
 public:
  /// Keeps a reference to `scene`, whose camera it is.
  explicit CameraRays(const Scene& scene) : scene_(scene), basis_(scene.camera) {}

  Ray through(double x, double y, float time) const;

 private:
  struct Basis {
    explicit Basis(const Camera& camera);
    Vec3 position, forward, right, up;  ///< right and up span half the image
  };

  const Scene& scene_;
  Basis basis_;  ///< of a camera that stands still
};

/// Random points in a scene's bounds and on its triangles.
class GeometryPoints {
 public:
  explicit GeometryPoints(const Scene& scene);

  /// From a random point of the bounds in a random direction.
  Ray random_ray(Pcg32& random) const;
  /// From a random point of the bounds to a random point on a random triangle, at the ray's time; a random
  /// ray if the scene has no valid triangle there.
  Ray aimed_ray(Pcg32& random) const;

 private:
  Vec3 point_in_bounds(Pcg32& random) const;
  std::optional<Vec3> point_on_geometry(float time, Pcg32& random) const;

  const Scene& scene_;
  Vec3 lower_, extent_;
  std::vector<std::size_t> first_triangle_;  ///< of each mesh in a count over all, and their sum
};

}  // namespace stbvh::harness
