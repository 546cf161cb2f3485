/// The ends of a ray's range at and near its hits, and rays that leave from hit points.
#include <cmath>
#include <limits>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"
#include "harness/oracle/oracle.h"
#include "harness/rays/ray_sources.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSegments = 8;

/// A body within a body, both seen from everywhere, so that rays have several hits.
HardCase two_bodies(std::size_t count, Pcg32& random) {
  Scene scene = one_mesh(make_body({.segments = kSegments}));
  scene.meshes.push_back(make_body({.segments = 3, .radius = 0.4}));
  return seen_from(std::move(scene), {}, 2, count, random);
}

/// Changes the range of a ray whose nearest hit is at `t`.
using Cut = void (*)(Ray& ray, float t, Pcg32& random);

HardFamily cut_ranges(std::string_view name, std::string_view description, Expected expected, Cut cut) {
  return {.name = std::string(name),
          .description = std::string(description),
          .make = [expected, cut](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 50);
            HardCase result = two_bodies(count, random);
            result.expected = expected;
            const std::vector<OracleAnswer> answers = Oracle(result.scene).answers(result.rays);
            for (std::size_t i = 0; i < count; ++i) {
              const float t = answers[i].is_hit ? static_cast<float>(answers[i].t) : 1.0f;
              if (t > 0) cut(result.rays[i], t, random);
            }
            return one_case(std::move(result));
          }};
}

/// Off `t` by 1e-2 to 1e-6 of it, on either side.
float beside(float t, Pcg32& random) {
  const double part = std::pow(10.0, -random.uniform(2, 6)) * (random.uniform() < 0.5 ? -1 : 1);
  return static_cast<float>(t * (1 + part));
}

/// A ray of a hit point's, and what it leaves from.
struct Departure {
  Ray ray;
  TriangleId from;
};

/// Cosine-distributed from a hit point, `ulps` units in the last place of its coordinates off the surface, as
/// a path tracer starts its next ray.
Departure departure(const Scene& scene, const Ray& ray, const OracleAnswer& answer, double ulps,
                    Pcg32& random) {
  const SurfacePoint p = point_off_surface(scene.meshes[answer.geom_id], answer.prim_id, ray, answer.t, ulps);
  const Vec3 onward = normalize(p.normal + random_direction(random) * 0.9999);
  return {make_ray(p.position, onward, std::numeric_limits<double>::infinity(), p.time),
          {answer.geom_id, answer.prim_id}};
}

HardFamily leaving(std::string_view name, std::string_view description, double offset, double ulps) {
  return {.name = std::string(name),
          .description = std::string(description),
          .make = [offset, ulps](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 51);
            const Vec3 center = Vec3{1, -0.7, 0.4} * offset;
            Scene scene = one_mesh(make_body({.segments = kSegments, .radius = 16, .center = center}));
            HardCase result = seen_from(std::move(scene), center, 40, count, random);
            const std::vector<OracleAnswer> answers = Oracle(result.scene).answers(result.rays);
            std::vector<Ray> rays;
            for (std::size_t i = 0; i < count; ++i) {
              if (!answers[i].is_hit) continue;
              const Departure next = departure(result.scene, result.rays[i], answers[i], ulps, random);
              rays.push_back(next.ray);
              result.leaving.push_back(next.from);
            }
            result.rays = std::move(rays);
            return one_case(std::move(result));
          }};
}

}  // namespace

void add_range_families(std::vector<HardFamily>& families) {
  families.push_back(cut_ranges("tnear-beside-hit", "tnear just before or behind the nearest hit.",
                                Expected::kOracle,
                                [](Ray& ray, float t, Pcg32& r) { ray.tnear = beside(t, r); }));
  families.push_back(cut_ranges("tfar-beside-hit", "tfar just before or behind the nearest hit.",
                                Expected::kOracle,
                                [](Ray& ray, float t, Pcg32& r) { ray.tfar = beside(t, r); }));
  families.push_back(cut_ranges("tnear-at-hit", "tnear at the nearest hit's float, or one beside it.",
                                Expected::kOracle,
                                [](Ray& ray, float t, Pcg32& r) { ray.tnear = ulp_around(t, r); }));
  families.push_back(cut_ranges("tfar-at-hit", "tfar at the nearest hit's float, or one beside it.",
                                Expected::kOracle,
                                [](Ray& ray, float t, Pcg32& r) { ray.tfar = ulp_around(t, r); }));
  families.push_back(cut_ranges("empty-range", "tnear = tfar at a hit: nothing is left to hit.",
                                Expected::kNothing,
                                [](Ray& ray, float t, Pcg32&) { ray.tnear = ray.tfar = t; }));
  families.push_back(
      leaving("leaving-64-ulps", "From hit points, as far off as a path tracer starts.", 0, 64));
  families.push_back(leaving("leaving-8-ulps", "From hit points, an eighth of that off.", 0, 8));
  families.push_back(leaving("leaving-far-64-ulps", "From hit points 1e5 away, 64 ulps off.", 1e5, 64));
  families.push_back(
      leaving("leaving-surface", "From hit points themselves: a path tracer's mistake.", 0, 0));
}

}  // namespace stbvh::harness
