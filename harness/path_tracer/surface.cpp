#include "harness/path_tracer/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "harness/scenes/moving_triangle.h"

namespace stbvh::harness {
namespace {

/// Sixteen roundings of the largest coordinate, as float: interpolating vertices, moving them to the ray's
/// origin and the edge functions take fewer.
constexpr double kClearance = 0x1p-19;

double largest_coordinate(const std::array<Vec3, 3>& p) {
  double largest = 0;
  for (Vec3 a : p) largest = std::max({largest, std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  return largest;
}

Surface make_surface(const std::array<Vec3, 3>& p, double u, double v) {
  const Vec3 area = area_vector(p);
  const double doubled = length(area);
  return {.position = p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]),
          .normal = doubled > 0 ? (1 / doubled) * area : Vec3{},
          .clearance = kClearance * largest_coordinate(p),
          .u = u,
          .v = v};
}

Vec3 above(const Surface& surface, Vec3 direction) {
  const double side = dot(direction, surface.normal) < 0 ? -surface.clearance : surface.clearance;
  return surface.position + side * surface.normal;
}

}  // namespace

Surface surface_at(const Mesh& mesh, const Ray& ray, const Hit& hit) {
  const std::array<Vec3, 3> p = triangle_at(mesh, hit.prim_id, motion_sample(mesh, ray.time));
  const Vec3 origin = to_double(ray.origin), direction = to_double(ray.direction);
  const Vec3 area = area_vector(p);
  const double slope = dot(area, direction), doubled2 = dot(area, area);
  double u = hit.u, v = hit.v;
  if (slope * slope > 1e-24 * doubled2 * dot(direction, direction)) {
    const Vec3 at = origin + (dot(area, p[0] - origin) / slope) * direction - p[0];
    u = dot(cross(at, p[2] - p[0]), area) / doubled2;
    v = dot(cross(p[1] - p[0], at), area) / doubled2;
  }
  // Structures let rays hit edges that they pass within rounding.
  u = std::clamp(u, 0.0, 1.0);
  v = std::clamp(v, 0.0, 1 - u);
  return make_surface(p, u, v);
}

Surface surface_point(const Mesh& mesh, std::size_t prim, double u, double v, float time) {
  return make_surface(triangle_at(mesh, prim, motion_sample(mesh, time)), u, v);
}

Ray ray_from(const Surface& surface, Vec3 direction, float time) {
  return {.origin = to_float(above(surface, direction)),
          .tnear = 0,
          .direction = to_float(direction),
          .time = time,
          .tfar = std::numeric_limits<float>::infinity(),
          .mask = 0xFFFFFFFFu};
}

Ray ray_between(const Surface& surface, const Surface& target, float time) {
  const Vec3 direction = target.position - surface.position;
  Ray ray = ray_from(surface, direction, time);
  ray.direction = to_float(above(target, -direction) - to_double(ray.origin));
  ray.tfar = 1;
  return ray;
}

}  // namespace stbvh::harness
