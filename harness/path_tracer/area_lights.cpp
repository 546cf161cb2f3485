#include <fmt/format.h>

#include <limits>
#include <stdexcept>

#include "harness/path_tracer/lights.h"
#include "harness/scenes/moving_triangle.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kNoLight = std::numeric_limits<std::size_t>::max();

double mean_area(const Mesh& mesh, std::size_t prim) {
  double sum = 0;
  for (std::size_t k = 0; k < mesh.steps.size(); ++k) {
    // The first moment of a segment, but for the last step.
    const bool is_last = k > 0 && k + 1 == mesh.steps.size();
    const MotionSample sample = is_last ? MotionSample{k - 1, 1.0} : MotionSample{k, 0.0};
    sum += 0.5 * length(area_vector(triangle_at(mesh, prim, sample)));
  }
  return sum / static_cast<double>(mesh.steps.size());
}

}  // namespace

AreaLights::AreaLights(const Scene& scene) : scene_(scene) {
  std::vector<double> powers;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const Color emission = to_double(mesh.material.emission);
    if (!is_light(emission)) {
      throw std::invalid_argument(
          fmt::format("The mesh \"{}\" emits light that is negative or not finite.", mesh.name));
    }
    emission_.push_back(emission);
    first_.push_back(kNoLight);
    if (is_black(emission) || mesh.mask == 0) continue;
    first_.back() = triangles_.size();
    for (std::size_t prim = 0; prim < mesh.triangle_count(); ++prim) {
      triangles_.push_back({m, prim});
      powers.push_back(is_valid_triangle(mesh, prim) ? luminance(emission) * mean_area(mesh, prim) : 0);
    }
  }
  choice_ = Distribution(powers);
}

double AreaLights::density_of(double probability, Vec3 from, const Surface& surface, double area) const {
  const Vec3 to_light = surface.position - from;
  const double distance2 = dot(to_light, to_light);
  const double cosine = std::abs(dot(to_light, surface.normal)) / std::sqrt(distance2);
  return cosine > 0 && area > 0 ? probability / area * distance2 / cosine : 0;
}

std::optional<LightSample> AreaLights::sample(Vec3 from, float time, double choice, SamplePoint point) const {
  if (empty()) return std::nullopt;
  const Distribution::Pick pick = choice_.pick(choice);
  const Triangle& chosen = triangles_[pick.index];
  const Mesh& mesh = scene_.meshes[chosen.mesh];
  if (!is_visible_at(mesh, time)) return std::nullopt;
  const double root = std::sqrt(point.x);  // uniform in the triangle
  const Surface target = surface_point(mesh, chosen.prim, root * (1 - point.y), root * point.y, time);
  const double area = 0.5 * length(area_vector(triangle_at(mesh, chosen.prim, motion_sample(mesh, time))));
  const double density = density_of(pick.probability, from, target, area);
  if (!(density > 0) || !std::isfinite(density)) return std::nullopt;
  return LightSample{normalize(target.position - from), emission_[chosen.mesh], density, false, target};
}

double AreaLights::density(Vec3 from, const Surface& surface, std::size_t mesh, std::size_t prim,
                           float time) const {
  if (first_[mesh] == kNoLight) return 0;
  const Mesh& m = scene_.meshes[mesh];
  const double area = 0.5 * length(area_vector(triangle_at(m, prim, motion_sample(m, time))));
  return density_of(choice_.probability(first_[mesh] + prim), from, surface, area);
}

}  // namespace stbvh::harness
