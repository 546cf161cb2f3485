#include "harness/path_tracer/path_tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

#include "harness/rays/ray_generator.h"

namespace stbvh::harness {
namespace {

// Pairs of dimensions of a sample: three of the camera, then some for each bounce.
enum CameraDimension : std::uint32_t { kPixel, kLens, kTime, kCameraDimensions };
enum BounceDimension : std::uint32_t {
  kAreaChoice,
  kAreaPoint,
  kDirectionalChoice,
  kDirectionalPoint,
  kEnvironmentPoint,
  kScatterChoice,
  kScatterPoint,
  kRoulette,
  kBounceDimensions
};
constexpr std::size_t kBouncesBeforeRoulette = 3;

std::uint32_t dimension(std::size_t bounce, BounceDimension d) {
  return static_cast<std::uint32_t>(kCameraDimensions + kBounceDimensions * bounce + d);
}

void check_mesh(const Mesh& mesh) {
  const auto refuse = [&mesh](const char* reason) {
    throw std::invalid_argument(fmt::format("The mesh \"{}\" cannot be shown: {}.", mesh.name, reason));
  };
  if (mesh.steps.empty()) refuse("it has no steps");
  if (mesh.steps.size() > kMaxSteps) refuse("it has too many steps");
  const bool has_times = mesh.has_step_times() && !mesh.is_static();
  if (has_times && mesh.step_times.size() != mesh.steps.size()) refuse("it has not a time for each step");
  if (has_times && std::adjacent_find(mesh.step_times.begin(), mesh.step_times.end(),
                                      std::greater_equal<>()) != mesh.step_times.end()) {
    refuse("the times of its steps do not increase");
  }
  for (const VertexBuffer& step : mesh.steps) {
    if (step.size() != mesh.steps.front().size()) refuse("its steps have different numbers of vertices");
  }
  const TimeRange range = mesh.motion_range();
  if (!(std::isfinite(range.begin) && std::isfinite(range.end) && range.begin < range.end)) {
    refuse("its time range is empty");
  }
}

const Scene& checked(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) check_mesh(mesh);
  return scene;
}

/// The scene's own lights far away, or a sun and a sky where it has no light at all.
struct FarLights {
  std::vector<DirectionalLight> directional;
  std::optional<Environment> environment;
};
FarLights far_lights(const Scene& scene, bool has_area_lights) {
  if (has_area_lights || scene.environment || !scene.directional_lights.empty() ||
      !scene.point_lights.empty()) {
    return {scene.directional_lights, scene.environment};
  }
  DefaultLights lights = sun_and_sky(scene.camera);
  return {{lights.sun}, std::move(lights.sky)};
}

Ray to_ray(const CameraRay& ray, float time) {
  return {.origin = to_float(ray.origin),
          .tnear = 0,
          .direction = to_float(ray.direction),
          .time = time,
          .tfar = std::numeric_limits<float>::infinity(),
          .mask = 0xFFFFFFFFu};
}

/// The power heuristic.
double power_weight(double density, double other) {
  const double ratio = other / density;
  return 1 / (1 + ratio * ratio);
}

}  // namespace

PathTracer::PathTracer(const Scene& scene, const StructureUnderTest& structure,
                       const RenderSettings& settings)
    : scene_(checked(scene)),
      structure_(structure),
      settings_(settings),
      camera_(settings.camera.value_or(scene.camera), settings.lens, settings.width, settings.height),
      camera_moves_(!settings.camera && !scene.camera_steps.empty()),
      lights_(lights_of(scene)) {
  check_shutter(settings.shutter);
  using Key = std::tuple<Material::Kind, float, float, float, float, float>;
  std::map<Key, std::size_t> known;
  for (const Mesh& mesh : scene.meshes) {
    const Material& m = mesh.material;
    const Key key{m.kind, m.color.x, m.color.y, m.color.z, m.roughness, m.index_of_refraction};
    const auto [entry, is_new] = known.try_emplace(key, materials_.size());
    if (is_new) {
      try {
        materials_.emplace_back(m);
      } catch (const std::invalid_argument& e) {
        throw std::invalid_argument(fmt::format("The mesh \"{}\" cannot be shown: {}.", mesh.name, e.what()));
      }
    }
    material_of_.push_back(entry->second);
  }
}

SobolSampler PathTracer::sampler_of(std::size_t x, std::size_t y, std::size_t sample) const {
  return {settings_.seed, y * settings_.width + x, static_cast<std::uint32_t>(sample)};
}

LensCamera PathTracer::camera_at(double time) const {
  if (!camera_moves_) return camera_;
  return {scene_.camera_at(time), settings_.lens, settings_.width, settings_.height};
}

CameraRay PathTracer::lens_ray(const SobolSampler& sampler, std::size_t x, std::size_t y, float time) const {
  const SamplePoint jitter = sampler.pair(kPixel);
  return camera_at(time).ray({static_cast<double>(x) + jitter.x, static_cast<double>(y) + jitter.y},
                             sampler.pair(kLens));
}

Ray PathTracer::camera_ray(std::size_t x, std::size_t y, std::size_t sample) const {
  const SobolSampler sampler = sampler_of(x, y, sample);
  const float time = settings_.shutter.time_at(sampler.number(kTime));
  return to_ray(lens_ray(sampler, x, y, time), time);
}

PathTracer::Lights PathTracer::lights_of(const Scene& scene) {
  AreaLights area(scene);
  FarLights far = far_lights(scene, !area.empty());
  return {std::move(area), DirectionalLights(far.directional), PointLights(scene.point_lights),
          EnvironmentLight(std::move(far.environment))};
}

PathSample PathTracer::trace(std::size_t x, std::size_t y, std::size_t index) const {
  const SobolSampler sampler = sampler_of(x, y, index);
  PathSample sample;
  sample.time = settings_.shutter.time_at(sampler.number(kTime));
  const CameraRay start = lens_ray(sampler, x, y, sample.time);
  Walk walk{.sampler = sampler, .ray = to_ray(start, sample.time), .from = start.origin};
  for (;; ++walk.bounce) {
    Hit hit;
    if (!find_hit(walk, hit, sample)) {
      sample.radiance = sample.radiance + modulate(walk.throughput, escaped(walk));
      return sample;
    }
    const Surface surface = surface_at(scene_.meshes[hit.mesh], walk.ray, hit);
    if (walk.bounce == 0) sample.first = first_hit(hit, surface, walk.ray);
    sample.radiance = sample.radiance + modulate(walk.throughput, emitted(walk, hit, surface));
    if (walk.bounce == settings_.max_bounces || length(surface.normal) == 0) return sample;
    const Vec3 viewer = normalize(-to_double(walk.ray.direction));
    const bool is_outside = dot(viewer, surface.normal) >= 0;
    const Frame frame(is_outside ? surface.normal : -surface.normal);
    const Vertex vertex{surface, frame, frame.to_local(viewer), materials_[material_of_[hit.mesh]],
                        is_outside};
    sample.radiance = sample.radiance + modulate(walk.throughput, direct(walk, vertex, sample));
    if (!scatter(walk, vertex)) return sample;
  }
}

bool PathTracer::find_hit(const Walk& walk, Hit& hit, PathSample& sample) const {
  ++sample.rays;
  if (!is_traceable(walk.ray)) return false;
  if (walk.bounce > 0) return structure_.intersect_one(walk.ray, hit);
  return structure_.intersect_one_counted(walk.ray, hit, sample.counters);
}

FirstHit PathTracer::first_hit(const Hit& hit, const Surface& surface, const Ray& ray) const {
  const Mesh& mesh = scene_.meshes[hit.mesh];
  const Vec3 normal = to_double(hit.normal), direction = to_double(ray.direction);
  FirstHit first;
  first.is_hit = true;
  first.albedo = materials_[material_of_[hit.mesh]].color();
  first.depth = static_cast<double>(hit.t) * length(direction);
  first.mesh = hit.mesh;
  first.prim = hit.prim_id;
  first.face = mesh.face_of(hit.prim_id);
  if (length(normal) > 0) first.normal = normalize(dot(normal, direction) > 0 ? -normal : normal);
  if (mesh.is_static() && !camera_moves_) return first;
  const auto place_at = [&](double time) {
    const TimeRange range = mesh.motion_range();
    const float seen = std::clamp(static_cast<float>(time), range.begin, range.end);
    return camera_at(time).project(surface_point(mesh, hit.prim_id, surface.u, surface.v, seen).position);
  };
  const auto begin = place_at(settings_.shutter.open), end = place_at(settings_.shutter.close);
  if (begin && end) {
    first.motion_x = end->x - begin->x;
    first.motion_y = end->y - begin->y;
  }
  return first;
}

/// Light that a ray meets where nothing is in its way.
Color PathTracer::escaped(const Walk& walk) const {
  const Vec3 direction = normalize(to_double(walk.ray.direction));
  Color sum =
      scatter_weight(walk, lights_.environment.density(direction)) * lights_.environment.radiance(direction);
  for (const DirectionalLights::Disc& disc : lights_.directional.discs()) {
    if (disc.holds(direction)) sum = sum + scatter_weight(walk, disc.density) * disc.radiance;
  }
  return sum;
}

Color PathTracer::emitted(const Walk& walk, const Hit& hit, const Surface& surface) const {
  const Color emission = lights_.area.emission(hit.mesh);
  if (is_black(emission)) return {};
  const double density =
      walk.is_specular ? 0 : lights_.area.density(walk.from, surface, hit.mesh, hit.prim_id, walk.ray.time);
  return scatter_weight(walk, density) * emission;
}

Color PathTracer::direct(const Walk& walk, const Vertex& vertex, PathSample& sample) const {
  if (vertex.bsdf.is_specular()) return {};
  const auto number = [&](BounceDimension d) { return walk.sampler.number(dimension(walk.bounce, d)); };
  const auto pair = [&](BounceDimension d) { return walk.sampler.pair(dimension(walk.bounce, d)); };
  const Vec3 position = vertex.surface.position;
  Color sum;
  if (const auto light = lights_.area.sample(position, walk.ray.time, number(kAreaChoice), pair(kAreaPoint)))
    sum = sum + lit(walk, vertex, *light, sample);
  if (const auto light = lights_.directional.sample(number(kDirectionalChoice), pair(kDirectionalPoint)))
    sum = sum + lit(walk, vertex, *light, sample);
  // The same number: what it chooses among here has nothing to do with what it chose before.
  if (const auto light = lights_.point.sample(position, number(kDirectionalChoice)))
    sum = sum + lit(walk, vertex, *light, sample);
  if (const auto light = lights_.environment.sample(pair(kEnvironmentPoint)))
    sum = sum + lit(walk, vertex, *light, sample);
  return sum;
}

Color PathTracer::lit(const Walk& walk, const Vertex& vertex, const LightSample& light,
                      PathSample& sample) const {
  const Vec3 local = vertex.frame.to_local(light.direction);
  const Color reflected = vertex.bsdf.evaluate(vertex.viewer, local);
  const double weight =
      light.is_delta ? 1 : light_weight(light.density, vertex.bsdf.density(vertex.viewer, local));
  if (is_black(reflected) || weight == 0) return {};
  const float time = walk.ray.time;
  const Ray ray = light.target ? ray_between(vertex.surface, *light.target, time)
                               : ray_from(vertex.surface, light.direction, time);
  ++sample.rays;
  if (is_traceable(ray) && structure_.occluded_one(ray)) return {};
  return (weight / light.density) * modulate(reflected, light.radiance);
}

/// Sends the path on; false where it ends.
bool PathTracer::scatter(Walk& walk, const Vertex& vertex) const {
  const double choice = walk.sampler.number(dimension(walk.bounce, kScatterChoice));
  const SamplePoint point = walk.sampler.pair(dimension(walk.bounce, kScatterPoint));
  const auto scattered = vertex.bsdf.sample(vertex.viewer, vertex.is_outside, choice, point);
  if (!scattered) return false;
  walk.throughput = modulate(walk.throughput, scattered->weight);
  if (walk.bounce >= kBouncesBeforeRoulette) {
    const double survival = std::min(1.0, largest(walk.throughput));
    if (!(walk.sampler.number(dimension(walk.bounce, kRoulette)) < survival)) return false;
    walk.throughput = (1 / survival) * walk.throughput;
  }
  if (is_black(walk.throughput)) return false;
  walk.ray = ray_from(vertex.surface, vertex.frame.to_world(scattered->direction), walk.ray.time);
  walk.density = scattered->density;
  walk.is_specular = scattered->is_specular;
  walk.from = vertex.surface.position;
  return true;
}

double PathTracer::light_weight(double light_density, double scatter_density) const {
  if (settings_.light_search == LightSearch::kLightsOnly) return 1;
  if (settings_.light_search == LightSearch::kScatteringOnly) return 0;
  return power_weight(light_density, scatter_density);
}

/// Of light that the ray of `walk` met by scattering, where light sampling has `light_density`.
double PathTracer::scatter_weight(const Walk& walk, double light_density) const {
  if (walk.is_specular || light_density == 0) return 1;
  if (settings_.light_search == LightSearch::kLightsOnly) return 0;
  if (settings_.light_search == LightSearch::kScatteringOnly) return 1;
  return power_weight(walk.density, light_density);
}

}  // namespace stbvh::harness
