#include "harness/path_tracer/bsdf.h"

#include <stdexcept>

#include "harness/path_tracer/directions.h"

namespace stbvh::harness {
namespace {

constexpr double kLeastAlpha = 1e-3;  // smoother coats would be mirrors that no light sampling finds

bool is_unit_color(Color c) {
  return c.x >= 0 && c.y >= 0 && c.z >= 0 && largest(c) <= 1;
}

Vec3 reflected(Vec3 viewer, Vec3 normal) {
  return 2 * dot(viewer, normal) * normal - viewer;
}

// GGX in the local frame; `h` is the normal of a facet.
double facet_density(double alpha, Vec3 h) {
  const double a2 = alpha * alpha;
  const double d = h.z * h.z * (a2 - 1) + 1;
  return a2 / (kPi * d * d);
}
/// Smith's lambda.
double lambda(double alpha, Vec3 v) {
  const double tangent2 = (v.x * v.x + v.y * v.y) / (v.z * v.z);
  return 0.5 * (std::sqrt(1 + alpha * alpha * tangent2) - 1);
}
double seen_from_one(double alpha, Vec3 v) {
  return 1 / (1 + lambda(alpha, v));
}
double seen_from_both(double alpha, Vec3 v, Vec3 l) {
  return 1 / (1 + lambda(alpha, v) + lambda(alpha, l));
}

/// Normal of a facet that `v` sees, with the density of those it sees (Heitz 2018).
Vec3 visible_facet(double alpha, Vec3 v, SamplePoint s) {
  const Vec3 stretched = normalize(Vec3{alpha * v.x, alpha * v.y, v.z});
  const double across = stretched.x * stretched.x + stretched.y * stretched.y;
  const Vec3 t1 = across > 0 ? (1 / std::sqrt(across)) * Vec3{-stretched.y, stretched.x, 0} : Vec3{1, 0, 0};
  const Vec3 t2 = cross(stretched, t1);
  const double radius = std::sqrt(s.x), angle = 2 * kPi * s.y;
  const double p1 = radius * std::cos(angle);
  const double tilt = 0.5 * (1 + stretched.z);
  const double p2 = (1 - tilt) * std::sqrt(1 - p1 * p1) + tilt * radius * std::sin(angle);
  const double p3 = std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2));
  const Vec3 facet = p1 * t1 + p2 * t2 + p3 * stretched;
  return normalize(Vec3{alpha * facet.x, alpha * facet.y, std::max(1e-12, facet.z)});
}

}  // namespace

double fresnel(double cosine, double index) {
  const double sine2 = (1 - cosine * cosine) / (index * index);
  if (sine2 >= 1) return 1;
  const double refracted = std::sqrt(1 - sine2);
  const double s = (cosine - index * refracted) / (cosine + index * refracted);
  const double p = (index * cosine - refracted) / (index * cosine + refracted);
  return 0.5 * (s * s + p * p);
}

CoatTable::CoatTable(double alpha, double index) {
  constexpr std::uint32_t kPoints = 1024;
  for (std::size_t i = 0; i <= kEntries; ++i) {
    const double cosine = std::max(1e-3, static_cast<double>(i) / kEntries);
    const Vec3 viewer{std::sqrt(std::max(0.0, 1 - cosine * cosine)), 0, cosine};
    double sum = 0;
    for (std::uint32_t k = 0; k < kPoints; ++k) {
      const Vec3 facet = visible_facet(alpha, viewer, scrambled_sobol(k, 0));
      const Vec3 light = reflected(viewer, facet);
      if (light.z <= 0) continue;
      sum += fresnel(dot(viewer, facet), index) * seen_from_both(alpha, viewer, light) /
             seen_from_one(alpha, viewer);
    }
    albedo_[i] = sum / kPoints;
  }
  // The integral of 2 E(c) c, exactly as `at` interpolates E, so that no energy is made.
  for (std::size_t i = 0; i < kEntries; ++i) {
    const double a = static_cast<double>(i) / kEntries, width = 1.0 / kEntries;
    mean_ += width * (albedo_[i] * (a + width / 3) + albedo_[i + 1] * (a + 2 * width / 3));
  }
}

double CoatTable::at(double cosine) const {
  const double x = std::clamp(cosine, 0.0, 1.0) * kEntries;
  const std::size_t i = std::min(static_cast<std::size_t>(x), kEntries - 1);
  return lerp(albedo_[i], albedo_[i + 1], x - static_cast<double>(i));
}

Bsdf::Bsdf(const Material& material)
    : kind_(material.kind),
      color_{material.color.x, material.color.y, material.color.z},
      index_(material.index_of_refraction) {
  const double roughness = material.roughness;
  if (!is_unit_color(color_)) throw std::invalid_argument("a color is not between 0 and 1");
  if (!(roughness >= 0 && roughness <= 1)) throw std::invalid_argument("a roughness is not between 0 and 1");
  if (!(index_ >= 1 && index_ <= 10)) {
    throw std::invalid_argument("an index of refraction is not between 1 and 10");
  }
  if (kind_ == Material::Kind::kGlossy) {
    alpha_ = std::max(kLeastAlpha, roughness * roughness);
    coat_.emplace(alpha_, index_);
  }
}

bool Bsdf::is_specular() const {
  return kind_ == Material::Kind::kMirror || kind_ == Material::Kind::kGlass;
}

/// Share of the samples that the coat gets: its share of the reflected light, never none nor all.
double Bsdf::coat_share(double cosine) const {
  const double coat = coat_->at(cosine);
  const double base = (1 - coat) * luminance(color_);
  return std::clamp(coat / (coat + base + 1e-9), 0.05, 0.95);
}

Color Bsdf::coat_and_base(Vec3 viewer, Vec3 light) const {
  const Vec3 facet = normalize(viewer + light);
  const double coat = fresnel(std::clamp(dot(viewer, facet), 0.0, 1.0), index_) *
                      facet_density(alpha_, facet) * seen_from_both(alpha_, viewer, light) / (4 * viewer.z);
  const double through = (1 - coat_->at(viewer.z)) * (1 - coat_->at(light.z)) / (1 - coat_->mean());
  return Color{coat, coat, coat} + (through * light.z / kPi) * color_;
}

Color Bsdf::evaluate(Vec3 viewer, Vec3 light) const {
  if (is_specular() || viewer.z <= 0 || light.z <= 0) return {};
  if (kind_ == Material::Kind::kDiffuse) return (light.z / kPi) * color_;
  return coat_and_base(viewer, light);
}

double Bsdf::density(Vec3 viewer, Vec3 light) const {
  if (is_specular() || viewer.z <= 0 || light.z <= 0) return 0;
  const double base = light.z / kPi;
  if (kind_ == Material::Kind::kDiffuse) return base;
  const Vec3 facet = normalize(viewer + light);
  const double coat = facet_density(alpha_, facet) * seen_from_one(alpha_, viewer) / (4 * viewer.z);
  const double share = coat_share(viewer.z);
  return share * coat + (1 - share) * base;
}

std::optional<ScatterSample> Bsdf::sample(Vec3 viewer, bool is_outside, double choice,
                                          SamplePoint point) const {
  if (viewer.z <= 0) return std::nullopt;
  switch (kind_) {
    case Material::Kind::kDiffuse: {
      const Vec3 light = cosine_direction(point);
      if (light.z <= 0) return std::nullopt;
      return ScatterSample{light, color_, light.z / kPi, false};
    }
    case Material::Kind::kGlossy:
      return sample_glossy(viewer, choice, point);
    case Material::Kind::kMirror:
      return ScatterSample{{-viewer.x, -viewer.y, viewer.z}, color_, 0, true};
    case Material::Kind::kGlass:
      break;
  }
  return sample_glass(viewer, is_outside, choice);
}

std::optional<ScatterSample> Bsdf::sample_glossy(Vec3 viewer, double choice, SamplePoint point) const {
  const Vec3 light = choice < coat_share(viewer.z) ? reflected(viewer, visible_facet(alpha_, viewer, point))
                                                   : cosine_direction(point);
  const double d = density(viewer, light);
  if (!(d > 0)) return std::nullopt;
  return ScatterSample{light, (1 / d) * evaluate(viewer, light), d, false};
}

/// Reflects the Fresnel share of the samples and refracts the others, which the glass colors.
ScatterSample Bsdf::sample_glass(Vec3 viewer, bool is_outside, double choice) const {
  const double index = is_outside ? index_ : 1 / index_;
  if (choice < fresnel(std::min(viewer.z, 1.0), index)) {
    return {{-viewer.x, -viewer.y, viewer.z}, {1, 1, 1}, 0, true};
  }
  const double x = -viewer.x / index, y = -viewer.y / index;
  return {{x, y, -std::sqrt(std::max(0.0, 1 - x * x - y * y))}, color_, 0, true};
}

}  // namespace stbvh::harness
