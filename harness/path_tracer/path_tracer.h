/// Paths of light, from the camera backwards, through any structure under test.
///
/// Unidirectional path tracing (Kajiya 1986) with one time for all of a path, light sampling at each
/// vertex, both ways of finding light weighted by the power heuristic (Veach 1997), Russian roulette.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "harness/path_tracer/bsdf.h"
#include "harness/path_tracer/directions.h"
#include "harness/path_tracer/lights.h"
#include "harness/path_tracer/render_settings.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// What the camera's own ray met.
struct FirstHit {
  bool is_hit = false;
  Color albedo;
  Vec3 normal;          ///< as the structure gives it, of length 1, on the viewer's side
  double depth = 0;     ///< distance from the lens, as the structure gives it
  double motion_x = 0;  ///< of the point over the shutter, in pixels
  double motion_y = 0;
  std::uint32_t mesh = kInvalidId;
  std::uint32_t prim = kInvalidId;
  std::uint32_t face = kInvalidId;  ///< of the file: Mesh::face_of()
};

struct PathSample {
  Color radiance;
  float time = 0;
  FirstHit first;
  TraversalCounters counters;  ///< of the camera's ray, where the structure counts
  std::uint64_t rays = 0;
};

class PathTracer {
 public:
  /// Scene and structure, which was built over it, must outlive this. Throws std::invalid_argument for a
  /// camera, a lens, a shutter, a mesh, a material or a light that cannot be.
  PathTracer(const Scene& scene, const StructureUnderTest& structure, const RenderSettings& settings);

  /// Sample `sample` of the pixel (x, y): a function of these and the settings. May run on any number of
  /// threads at once.
  PathSample trace(std::size_t x, std::size_t y, std::size_t sample) const;
  /// The ray with which it starts.
  Ray camera_ray(std::size_t x, std::size_t y, std::size_t sample) const;

 private:
  /// How far a path has come.
  struct Walk {
    const SobolSampler& sampler;
    Ray ray;
    Color throughput{1, 1, 1};
    std::size_t bounce = 0;
    double density = 0;       ///< with which `ray` was drawn
    bool is_specular = true;  ///< `ray` is from the camera or from a single direction
    Vec3 from;                ///< where it was drawn
  };
  struct Vertex {
    Surface surface;
    Frame frame;  ///< z: the normal on the viewer's side
    Vec3 viewer;  ///< in it
    const Bsdf& bsdf;
    bool is_outside;
  };

  struct Lights {
    AreaLights area;
    DirectionalLights directional;
    PointLights point;
    EnvironmentLight environment;
  };

  static Lights lights_of(const Scene& scene);
  SobolSampler sampler_of(std::size_t x, std::size_t y, std::size_t sample) const;
  /// The camera at a time.
  LensCamera camera_at(double time) const;
  CameraRay lens_ray(const SobolSampler& sampler, std::size_t x, std::size_t y, float time) const;
  bool find_hit(const Walk& walk, Hit& hit, PathSample& sample) const;
  FirstHit first_hit(const Hit& hit, const Surface& surface, const Ray& ray) const;
  Color escaped(const Walk& walk) const;
  Color emitted(const Walk& walk, const Hit& hit, const Surface& surface) const;
  Color direct(const Walk& walk, const Vertex& vertex, PathSample& sample) const;
  Color lit(const Walk& walk, const Vertex& vertex, const LightSample& light, PathSample& sample) const;
  bool scatter(Walk& walk, const Vertex& vertex) const;
  double light_weight(double light_density, double scatter_density) const;
  double scatter_weight(const Walk& walk, double light_density) const;

  const Scene& scene_;
  const StructureUnderTest& structure_;
  const RenderSettings settings_;
  LensCamera camera_;  ///< at the first of its steps, where it moves
  bool camera_moves_;
  std::vector<Bsdf> materials_;           ///< each different one once
  std::vector<std::size_t> material_of_;  ///< of each mesh
  Lights lights_;
};

}  // namespace stbvh::harness
