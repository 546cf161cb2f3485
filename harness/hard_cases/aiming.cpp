#include "harness/hard_cases/aiming.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "harness/rays/ray_generator.h"
#include "harness/rays/ray_sources.h"
#include "harness/scenes/moving_triangle.h"

namespace stbvh::harness {
namespace {

std::size_t below(std::size_t n, Pcg32& random) {
  return std::min(static_cast<std::size_t>(random.uniform() * static_cast<double>(n)), n - 1);
}

std::vector<float> times_of_steps(const Mesh& mesh) {
  if (mesh.is_static()) return {mesh.time_range.begin};
  std::vector<float> times;
  for (std::size_t k = 0; k < mesh.steps.size(); ++k) times.push_back(static_cast<float>(mesh.step_time(k)));
  return times;
}

float one_of(const std::vector<float>& times, Pcg32& random) {
  return times.size() > 1 ? times[below(times.size(), random)] : times.front();
}

}  // namespace

TimeChoice mixed_times(const Mesh& mesh) {
  return [range = mesh.motion_range(), times = times_of_steps(mesh)](Pcg32& random) {
    if (random.uniform() < 0.25) return one_of(times, random);
    return static_cast<float>(random.uniform(range.begin, range.end));
  };
}

TimeChoice step_times(const Mesh& mesh) {
  return [times = times_of_steps(mesh)](Pcg32& random) {
    return std::clamp(ulp_around(one_of(times, random), random), 0.0f, 1.0f);
  };
}

float ulp_around(float value, Pcg32& random) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const double kind = random.uniform();
  if (kind < 1.0 / 3) return value;
  return std::nextafter(value, kind < 2.0 / 3 ? -kInf : kInf);
}

Vec3 point_on(const Mesh& mesh, std::size_t prim, float time, Place place, Pcg32& random) {
  const auto p = triangle_at(mesh, prim, motion_sample(mesh, time));
  const std::size_t corner = below(3, random);
  const double along = random.uniform();
  const double root = std::sqrt(random.uniform());
  if (place == Place::kVertex) return p[corner];
  if (place == Place::kEdge) return lerp(p[corner], p[(corner + 1) % 3], along);
  return p[0] * (1 - root) + p[1] * (root * (1 - along)) + p[2] * (root * along);
}

Ray aimed_ray(Vec3 origin, Vec3 target, float time) {
  const Vec3 start = to_double(to_float(origin));
  const Vec3 way = target - start;
  const double largest = std::max({std::abs(way.x), std::abs(way.y), std::abs(way.z)});
  const double scale = largest > 0 ? std::ldexp(1.0, -std::ilogb(largest)) : 1.0;
  return make_ray(start, way * scale, std::numeric_limits<double>::infinity(), time);
}

Ray ulp_beside(Ray ray, Pcg32& random) {
  float* components[] = {&ray.direction.x, &ray.direction.y, &ray.direction.z};
  float& moved = *components[below(3, random)];
  moved = std::nextafter(moved, random.uniform() < 0.5 ? -4.0f : 4.0f);
  return ray;
}

std::vector<Ray> rays_at(const Scene& scene, const Aims& aims, std::size_t count, Pcg32& random) {
  std::vector<Ray> rays;
  rays.reserve(count);
  while (rays.size() < count) {
    const Mesh& mesh = scene.meshes[below(scene.meshes.size(), random)];
    const std::size_t prim = below(mesh.triangle_count(), random);
    const float time = aims.time(random);
    const std::size_t i = rays.size();
    const Place place = aims.places[(aims.beside ? i / 2 : i) % aims.places.size()];
    Vec3 target;
    if (is_visible_at(mesh, time) && is_valid_triangle(mesh, prim)) {
      target = point_on(mesh, prim, time, place, random);
    }
    const Ray ray = aimed_ray(aims.origin(time, random), target, time);
    if (!is_traceable(ray)) continue;
    rays.push_back(aims.beside && i % 2 == 1 ? ulp_beside(ray, random) : ray);
  }
  return rays;
}

HardCase inside_body(const Body& body, const TimeChoice& time, std::size_t count, Pcg32& random) {
  HardCase result{.scene = one_mesh(make_body(body)), .expected = Expected::kClosed};
  const double reach = 0.5 * kInnerRadius * body.radius;
  const auto origin = [&](float t, Pcg32& r) {
    const Vec3 p = random_point(r, reach);
    return body.center_at(t) + Vec3{p.x * body.stretch.x, p.y * body.stretch.y, p.z * body.stretch.z};
  };
  result.rays = rays_at(result.scene, {time, origin, {Place::kVertex, Place::kEdge}, true}, count, random);
  return result;
}

HardCase inside_body(const Body& body, std::size_t count, Pcg32& random) {
  Mesh clock;
  clock.steps.resize(body.segments + 1);
  return inside_body(body, mixed_times(clock), count, random);
}

HardCase seen_from(Scene scene, Vec3 center, double extent, std::size_t count, Pcg32& random) {
  HardCase result{.scene = std::move(scene)};
  const auto origin = [&](float, Pcg32& r) { return center + random_point(r, extent); };
  result.rays = rays_at(result.scene, {.time = mixed_times(result.scene.meshes.front()), .origin = origin},
                        count, random);
  return result;
}

std::size_t share(std::size_t count, std::size_t i, std::size_t cases) {
  return count * (i + 1) / cases - count * i / cases;
}

}  // namespace stbvh::harness
