/// Where the light of pictures comes from, and how paths aim at it.
#pragma once

#include <optional>
#include <vector>

#include "harness/path_tracer/color.h"
#include "harness/path_tracer/distribution.h"
#include "harness/path_tracer/sobol_sampler.h"
#include "harness/path_tracer/surface.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// A direction from which light comes to a point.
struct LightSample {
  Vec3 direction;                 ///< unit, to the light
  Color radiance;                 ///< of a single direction (`is_delta`): irradiance
  double density = 0;             ///< in solid angle; of a single direction: probability
  bool is_delta = false;          ///< no scattered ray can meet it
  std::optional<Surface> target;  ///< where the light is; empty: far away
};

/// The triangles of all meshes that emit, on both sides, each chosen by its power: emission times mean area
/// over the steps.
class AreaLights {
 public:
  /// Throws std::invalid_argument for an emission that is negative or not finite.
  explicit AreaLights(const Scene& scene);

  bool empty() const { return !(choice_.total() > 0); }
  /// A point of a light at `time`, as `from` sees it; none where the chosen one does not exist then.
  std::optional<LightSample> sample(Vec3 from, float time, double choice, SamplePoint point) const;
  /// With which sample(from) draws the direction to the point `surface` of a triangle at `time`.
  double density(Vec3 from, const Surface& surface, std::size_t mesh, std::size_t prim, float time) const;
  Color emission(std::size_t mesh) const { return emission_[mesh]; }

 private:
  struct Triangle {
    std::size_t mesh;
    std::size_t prim;
  };
  double density_of(double probability, Vec3 from, const Surface& surface, double area) const;

  const Scene& scene_;
  std::vector<Color> emission_;     ///< of each mesh
  std::vector<std::size_t> first_;  ///< triangle of each mesh that emits, in triangles_
  std::vector<Triangle> triangles_;
  Distribution choice_;
};

/// Light out of discs far away; each chosen by its irradiance.
class DirectionalLights {
 public:
  /// Throws std::invalid_argument for lights without direction, with a negative irradiance or a disc of more
  /// than half the sky.
  explicit DirectionalLights(const std::vector<DirectionalLight>& lights);

  struct Disc {
    Vec3 center;            ///< unit, to the light
    double sine2_half = 0;  ///< of half of half its angle; 0: a single direction
    Color radiance;         ///< or irradiance
    double density = 0;     ///< with which sample draws each of its directions

    bool is_delta() const { return sine2_half == 0; }
    bool holds(Vec3 direction) const;
  };

  std::optional<LightSample> sample(double choice, SamplePoint point) const;
  const std::vector<Disc>& discs() const { return discs_; }

 private:
  std::vector<Disc> discs_;
  Distribution choice_;
};

/// Light from points; each chosen by its intensity.
class PointLights {
 public:
  /// Throws std::invalid_argument for lights without place or axis, with a negative intensity or a cone that
  /// ends before it begins.
  explicit PointLights(const std::vector<PointLight>& lights);

  /// One of them as `from` sees it; none where it does not shine there.
  std::optional<LightSample> sample(Vec3 from, double choice) const;

 private:
  struct Point {
    Vec3 position, axis;  ///< the axis of length 1
    Color intensity;
    double cos_inner = -1, cos_outer = -1;

    /// Share of the intensity in a direction of length 1.
    double share(Vec3 direction) const;
  };
  std::vector<Point> points_;
  Distribution choice_;
};

/// Light from all directions. A picture's parts are chosen by the light that they send; a constant is left
/// to scattered rays: there is nothing in it to aim at.
class EnvironmentLight {
 public:
  /// Throws std::invalid_argument for values that are negative or not finite, or pixels that are missing.
  explicit EnvironmentLight(std::optional<Environment> environment);

  /// Bilinear between the picture's pixels.
  Color radiance(Vec3 direction) const;
  double density(Vec3 direction) const;
  std::optional<LightSample> sample(SamplePoint point) const;

 private:
  Color pixel(std::size_t x, std::size_t y) const;
  /// Of a point of the picture, which is there.
  Color radiance_at(SamplePoint at) const;
  double density_at(SamplePoint at) const;

  std::optional<Environment> environment_;
  Distribution rows_;
  std::vector<Distribution> columns_;  ///< of each row
};

/// Unit vector of a point of a picture of latitude and longitude, x and y in [0, 1].
Vec3 latitude_longitude_direction(double x, double y);

/// What lights a scene that brings no light of its own: a sun, high behind the camera to its left, and a sky.
struct DefaultLights {
  DirectionalLight sun;
  Environment sky;
};
DefaultLights sun_and_sky(const Camera& camera);

}  // namespace stbvh::harness
