#include "harness/rays/ray_generator.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "harness/rays/ray_sources.h"

namespace stbvh::harness {
namespace {

constexpr std::array<std::pair<RayKind, std::string_view>, 6> kNames{{
    {RayKind::kPrimary, "primary"},
    {RayKind::kBounce, "bounce"},
    {RayKind::kUniform, "uniform"},
    {RayKind::kShadow, "shadow"},
    {RayKind::kBounceOccluded, "bounce-occluded"},
    {RayKind::kUniformOccluded, "uniform-occluded"},
}};
constexpr std::array<RayKind, 6> kKinds{RayKind::kPrimary,        RayKind::kBounce,
                                        RayKind::kUniform,        RayKind::kShadow,
                                        RayKind::kBounceOccluded, RayKind::kUniformOccluded};

/// The kind that has the same rays, asked for their closest hits.
RayKind closest_kind(RayKind kind) {
  if (kind == RayKind::kBounceOccluded) return RayKind::kBounce;
  if (kind == RayKind::kUniformOccluded) return RayKind::kUniform;
  return kind;
}

std::vector<HitRecord> trace(const StructureUnderTest& reference, std::span<const Ray> rays) {
  std::vector<HitRecord> hits(rays.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), 1024), [&](const auto& range) {
    reference.intersect(rays.subspan(range.begin(), range.size()),
                        std::span(hits).subspan(range.begin(), range.size()));
  });
  return hits;
}

/// Several times as far off the surface as what the oracle counts as rounding.
constexpr double kUlpsOffSurface = 64;

/// Up to `count` points that `reference` hits: through the camera, then aimed at geometry.
std::vector<SurfacePoint> hit_points(const Scene& scene, const StructureUnderTest& reference,
                                     std::size_t count, Pcg32& random) {
  constexpr int kBatches = 16;
  const CameraRays camera(scene);
  const GeometryPoints geometry(scene);
  std::vector<SurfacePoint> points;
  const std::size_t batch = std::max<std::size_t>(count, 4096);
  for (int round = 0; round < 2 * kBatches && points.size() < count; ++round) {
    const bool through_camera = round < kBatches;
    std::vector<Ray> rays;
    rays.reserve(batch);
    for (std::size_t i = 0; i < batch; ++i) {
      const Ray ray = through_camera ? camera.through(random.uniform(), random.uniform(), random_time(random))
                                     : geometry.aimed_ray(random);
      if (is_traceable(ray)) rays.push_back(ray);
    }
    const std::vector<HitRecord> hits = trace(reference, rays);
    for (std::size_t i = 0; i < rays.size() && points.size() < count; ++i) {
      if (!hits[i].is_hit()) continue;
      points.push_back(point_off_surface(scene.meshes[hits[i].geom_id], hits[i].prim_id, rays[i],
                                         static_cast<double>(hits[i].t), kUlpsOffSurface));
    }
  }
  return points;
}

std::vector<Ray> primary_rays(const Scene& scene, std::size_t count, Pcg32& random) {
  const CameraRays camera(scene);
  const double n = static_cast<double>(count);
  const auto width = static_cast<std::size_t>(std::ceil(std::sqrt(n * kPictureAspect)));
  const std::size_t height = (count + width - 1) / width;
  std::vector<Ray> rays;
  rays.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = (static_cast<double>(i % width) + random.uniform()) / static_cast<double>(width);
    const double y = (static_cast<double>(i / width) + random.uniform()) / static_cast<double>(height);
    rays.push_back(camera.through(x, y, random_time(random)));
  }
  return rays;
}

std::vector<Ray> uniform_rays(const Scene& scene, std::size_t count, Pcg32& random) {
  const GeometryPoints geometry(scene);
  std::vector<Ray> rays;
  rays.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    rays.push_back(i % 2 == 0 ? geometry.random_ray(random) : geometry.aimed_ray(random));
  }
  return rays;
}

std::vector<Ray> bounce_rays(std::span<const SurfacePoint> points, Pcg32& random) {
  std::vector<Ray> rays;
  rays.reserve(points.size());
  for (const SurfacePoint& p : points) {
    // A point of the unit sphere around the tip of the normal: cosine-distributed once normalised.
    const Vec3 direction = normalize(p.normal + random_direction(random));
    rays.push_back(make_ray(p.position, direction, std::numeric_limits<double>::infinity(), p.time));
  }
  return rays;
}

std::vector<Ray> shadow_rays(const Scene& scene, std::span<const SurfacePoint> points, Pcg32& random) {
  const Box3f box = scene.bounds();
  const Vec3 center = 0.5 * (to_double(box.lower) + to_double(box.upper));
  const double diagonal = length(to_double(box.upper) - to_double(box.lower));
  const Vec3 up = normalize(to_double(scene.camera.up));
  const Vec3 light = center + diagonal * normalize(up + 0.5 * perpendicular(up));
  std::vector<Ray> rays;
  rays.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3 sky = random_direction(random);
    if (dot(sky, up) < 0) sky = -sky;
    const Vec3 to_target = (i % 2 == 0 ? light : center + diagonal * sky) - points[i].position;
    rays.push_back(make_ray(points[i].position, normalize(to_target), length(to_target), points[i].time));
  }
  return rays;
}

void shuffle(std::vector<Ray>& rays, Pcg32& random) {
  for (std::size_t i = rays.size(); i > 1; --i) {
    std::swap(rays[i - 1], rays[static_cast<std::size_t>(random.uniform() * static_cast<double>(i))]);
  }
}

}  // namespace

std::string_view ray_kind_name(RayKind kind) {
  return std::find_if(kNames.begin(), kNames.end(), [&](const auto& entry) { return entry.first == kind; })
      ->second;
}

std::span<const RayKind> ray_kinds() {
  return kKinds;
}

std::optional<RayKind> find_ray_kind(std::string_view name) {
  for (const auto& [kind, kind_name] : kNames) {
    if (kind_name == name) return kind;
  }
  return std::nullopt;
}

bool is_traceable(const Ray& ray) {
  const auto is_in_range = [](Vec3f v) {
    return std::abs(v.x) <= kMaxCoordinate && std::abs(v.y) <= kMaxCoordinate &&
           std::abs(v.z) <= kMaxCoordinate;
  };
  const Vec3f d = ray.direction;
  return is_in_range(ray.origin) && is_in_range(d) && (d.x != 0 || d.y != 0 || d.z != 0) && ray.time >= 0 &&
         ray.time <= 1 && ray.tnear >= 0 && ray.tnear <= ray.tfar;
}

RaySet make_rays(RayKind kind, const Scene& scene, const StructureUnderTest& reference, std::size_t count,
                 std::uint64_t seed) {
  const RayKind source = closest_kind(kind);
  Pcg32 random(seed, static_cast<std::uint64_t>(source));
  RaySet set{kind, {}};
  if (source == RayKind::kPrimary) {
    set.rays = primary_rays(scene, count, random);
  } else if (source == RayKind::kUniform) {
    set.rays = uniform_rays(scene, count, random);
  } else {
    const std::vector<SurfacePoint> points = hit_points(scene, reference, count, random);
    set.rays = source == RayKind::kBounce ? bounce_rays(points, random) : shadow_rays(scene, points, random);
    shuffle(set.rays, random);
  }
  std::erase_if(set.rays, [](const Ray& ray) { return !is_traceable(ray); });
  return set;
}

}  // namespace stbvh::harness
