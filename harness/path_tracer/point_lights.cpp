#include <algorithm>
#include <stdexcept>

#include "harness/path_tracer/directions.h"
#include "harness/path_tracer/lights.h"

namespace stbvh::harness {

PointLights::PointLights(const std::vector<PointLight>& lights) {
  std::vector<double> weights;
  for (const PointLight& light : lights) {
    const Vec3 position = to_double(light.position), axis = to_double(light.axis);
    const double inner = light.inner_angle_degrees, outer = light.outer_angle_degrees;
    if (!is_finite(position) || !is_finite(axis) || !(length(axis) > 0) ||
        !is_light(to_double(light.intensity)) || !(inner >= 0 && inner <= outer && outer <= 180)) {
      throw std::invalid_argument("A point light has no place, no light or no cone.");
    }
    points_.push_back({.position = position,
                       .axis = normalize(axis),
                       .intensity = to_double(light.intensity),
                       .cos_inner = std::cos(inner * kPi / 180),
                       .cos_outer = std::cos(outer * kPi / 180)});
    weights.push_back(luminance(points_.back().intensity));
  }
  choice_ = Distribution(weights);
}

/// As KHR_lights_punctual has it: a square of what falls linearly with the cosine.
double PointLights::Point::share(Vec3 direction) const {
  const double cosine = dot(direction, axis);
  if (cosine >= cos_inner) return 1;
  if (cosine <= cos_outer) return 0;
  const double linear = (cosine - cos_outer) / (cos_inner - cos_outer);
  return linear * linear;
}

std::optional<LightSample> PointLights::sample(Vec3 from, double choice) const {
  if (!(choice_.total() > 0)) return std::nullopt;
  const Distribution::Pick pick = choice_.pick(choice);
  const Point& point = points_[pick.index];
  const Vec3 to_light = point.position - from;
  const double distance2 = dot(to_light, to_light);
  const double share = distance2 > 0 ? point.share(normalize(-to_light)) : 0;
  if (!(share > 0)) return std::nullopt;
  const Surface target{.position = point.position, .normal = {}, .clearance = 0, .u = 0, .v = 0};
  return LightSample{normalize(to_light), (share / distance2) * point.intensity, pick.probability, true,
                     target};
}

}  // namespace stbvh::harness
