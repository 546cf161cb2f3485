#include "harness/rays/ray_sources.h"

#include <algorithm>
#include <cmath>

#include "harness/scenes/moving_triangle.h"

namespace stbvh::harness {

Ray make_ray(Vec3 origin, Vec3 direction, double tfar, float time) {
  return {.origin = to_float(origin),
          .tnear = 0.0f,
          .direction = to_float(direction),
          .time = time,
          .tfar = static_cast<float>(tfar),
          .mask = 0xFFFFFFFFu};
}

float random_time(Pcg32& random) {
  return static_cast<float>(random.uniform());
}

Vec3 random_direction(Pcg32& random) {
  const double z = random.uniform(-1, 1);
  const double angle = random.uniform(0, 2 * kPi);
  const double radius = std::sqrt(std::max(0.0, 1 - z * z));
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

SurfacePoint point_off_surface(const Mesh& mesh, std::size_t prim, const Ray& ray, double t, double ulps) {
  const auto p = triangle_at(mesh, prim, motion_sample(mesh, ray.time));
  const Vec3 direction = to_double(ray.direction);
  Vec3 normal = normalize(cross(p[1] - p[0], p[2] - p[0]));
  if (dot(normal, direction) > 0) normal = -normal;
  const Vec3 origin = to_double(ray.origin);
  const Vec3 along = direction * t;
  const double magnitude = length(origin) + length(along) + length(p[0]);
  return {origin + along + normal * (ulps * 0x1p-23 * magnitude), normal, ray.time};
}

CameraRays::Basis::Basis(const Camera& camera)
    : position(to_double(camera.position)),
      forward(normalize(to_double(camera.target) - to_double(camera.position))) {
  const Vec3 side = cross(forward, to_double(camera.up));
  const Vec3 to_right = length(side) > 0 ? normalize(side) : perpendicular(forward);
  const double half_height = std::tan(static_cast<double>(camera.vertical_fov_degrees) * kPi / 360);
  right = to_right * (half_height * kPictureAspect);
  up = cross(to_right, forward) * half_height;
}

Ray CameraRays::through(double x, double y, float time) const {
  const Basis basis = scene_.camera_steps.empty() ? basis_ : Basis(scene_.camera_at(time));
  const Vec3 direction = normalize(basis.forward + basis.right * (2 * x - 1) + basis.up * (1 - 2 * y));
  return make_ray(basis.position, direction, std::numeric_limits<double>::infinity(), time);
}

GeometryPoints::GeometryPoints(const Scene& scene) : scene_(scene) {
  const Box3f box = scene.bounds();
  lower_ = to_double(box.lower);
  extent_ = to_double(box.upper) - lower_;
  first_triangle_.push_back(0);
  for (const Mesh& mesh : scene.meshes)
    first_triangle_.push_back(first_triangle_.back() + mesh.triangle_count());
}

Vec3 GeometryPoints::point_in_bounds(Pcg32& random) const {
  const double x = random.uniform();
  const double y = random.uniform();
  const double z = random.uniform();
  return lower_ + Vec3{extent_.x * x, extent_.y * y, extent_.z * z};
}

Ray GeometryPoints::random_ray(Pcg32& random) const {
  const Vec3 origin = point_in_bounds(random);
  const Vec3 direction = random_direction(random);
  return make_ray(origin, direction, std::numeric_limits<double>::infinity(), random_time(random));
}

Ray GeometryPoints::aimed_ray(Pcg32& random) const {
  const float time = random_time(random);
  const std::optional<Vec3> target = point_on_geometry(time, random);
  if (!target) return random_ray(random);
  const Vec3 origin = point_in_bounds(random);
  return make_ray(origin, normalize(*target - origin), std::numeric_limits<double>::infinity(), time);
}

std::optional<Vec3> GeometryPoints::point_on_geometry(float time, Pcg32& random) const {
  constexpr int kAttempts = 16;  // a triangle may be invalid, a mesh invisible at `time`
  for (int attempt = 0; attempt < kAttempts && first_triangle_.back() > 0; ++attempt) {
    const double number = random.uniform() * static_cast<double>(first_triangle_.back());
    const auto next =
        std::upper_bound(first_triangle_.begin(), first_triangle_.end(), static_cast<std::size_t>(number));
    const auto mesh_index = static_cast<std::size_t>(next - first_triangle_.begin() - 1);
    const Mesh& mesh = scene_.meshes[mesh_index];
    const std::size_t prim = static_cast<std::size_t>(number) - first_triangle_[mesh_index];
    const double root = std::sqrt(random.uniform());
    const double along = random.uniform();
    if (!is_visible_at(mesh, time) || !is_valid_triangle(mesh, prim)) continue;
    const auto p = triangle_at(mesh, prim, motion_sample(mesh, time));
    return p[0] * (1 - root) + p[1] * (root * (1 - along)) + p[2] * (root * along);
  }
  return std::nullopt;
}

}  // namespace stbvh::harness
