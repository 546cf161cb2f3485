/// How the surfaces of pictures scatter light.
#pragma once

#include <array>
#include <optional>

#include "harness/path_tracer/color.h"
#include "harness/path_tracer/sobol_sampler.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// A scattered direction. Directions point away from the surface, in a frame whose z axis is the normal on
/// the viewer's side.
struct ScatterSample {
  Vec3 direction;
  Color weight;              ///< reflectance times cosine over density
  double density = 0;        ///< in solid angle
  bool is_specular = false;  ///< drawn from a single direction: no light sampling can find it
};

/// Share of unpolarised light that a smooth dielectric reflects (Fresnel), for light that comes from the side
/// of the index 1 at the cosine `cosine` in [0, 1] to the other side of index `index`.
double fresnel(double cosine, double index);

/// Share of light that the coat of a glossy material reflects into all directions, over the cosine of the
/// viewer: tabulated, linear between entries.
class CoatTable {
 public:
  CoatTable(double alpha, double index);

  double at(double cosine) const;
  /// Mean over all directions, weighted with the cosine.
  double mean() const { return mean_; }

 private:
  static constexpr std::size_t kEntries = 64;
  std::array<double, kEntries + 1> albedo_{};
  double mean_ = 0;
};

/// Scattering of one material. Diffuse: Lambert. Glossy: a rough coat with the distribution of GGX (Walter et
/// al. 2007; height-correlated masking, visible normals: Heitz 2014, 2018) over a diffuse base that gets what
/// the coat lets through, so that a white one reflects all light (Kelemen and Szirmay-Kalos 2001). Mirror and
/// glass: smooth. Glass carries radiance over the squared index, which no refraction changes.
class Bsdf {
 public:
  /// Throws std::invalid_argument for numbers out of range.
  explicit Bsdf(const Material& material);

  /// Whether light comes from single directions only: evaluate is then 0.
  bool is_specular() const;
  /// Reflectance times cosine for the unit directions to the viewer and to the light.
  Color evaluate(Vec3 viewer, Vec3 light) const;
  /// Density with which sample draws `light`.
  double density(Vec3 viewer, Vec3 light) const;
  /// Draws a direction; none where all light is absorbed. `is_outside`: the viewer is outside of the glass.
  std::optional<ScatterSample> sample(Vec3 viewer, bool is_outside, double choice, SamplePoint point) const;
  Color color() const { return color_; }

 private:
  double coat_share(double cosine) const;
  Color coat_and_base(Vec3 viewer, Vec3 light) const;
  std::optional<ScatterSample> sample_glossy(Vec3 viewer, double choice, SamplePoint point) const;
  ScatterSample sample_glass(Vec3 viewer, bool is_outside, double choice) const;

  Material::Kind kind_;
  Color color_;
  double index_;
  double alpha_ = 1;
  std::optional<CoatTable> coat_;
};

}  // namespace stbvh::harness
