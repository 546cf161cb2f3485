/// Far from the origin, tiny, huge, and both at once.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSegments = 8;

/// Triangles about as large as 1, at `offset` along each axis.
Body far_body(double offset) {
  return {.segments = kSegments, .radius = 16, .center = Vec3{1, -0.7, 0.4} * offset};
}

HardFamily far_inside(int power) {
  return {.name = fmt::format("offset-1e{}", power),
          .description =
              fmt::format("A closed body of triangles of size 1, 1e{} away, seen from its inside.", power),
          .make = [power](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 10);
            return one_case(inside_body(far_body(std::pow(10.0, power)), count, random));
          }};
}

HardFamily far_view(int power) {
  return {.name = fmt::format("far-view-1e{}", power),
          .description = fmt::format("The same seen from the world's origin, 1e{} away.", power),
          .make = [power](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 11);
            Scene scene = one_mesh(make_body(far_body(std::pow(10.0, power))));
            return one_case(seen_from(std::move(scene), {}, 1, count, random));
          }};
}

HardFamily far_sheet(int power) {
  return {
      .name = fmt::format("far-sheet-1e{}", power),
      .description = fmt::format("A waving sheet of triangles of size 1, 1e{} away, seen from near.", power),
      .make = [power](std::size_t count, std::uint64_t seed) {
        Pcg32 random(seed, 12);
        const Vec3 center = Vec3{1, -0.7, 0.4} * std::pow(10.0, power);
        Scene scene = one_mesh(make_sheet(32, kSegments, 16, center));
        return one_case(seen_from(std::move(scene), center + Vec3{0, 20, 0}, 10, count, random));
      }};
}

HardFamily scaled(int power) {
  return {.name = fmt::format("scale-1e{}", power),
          .description = fmt::format("A closed body of size 1e{} seen from inside.", power),
          .make = [power](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 13);
            const Body body{.segments = kSegments, .radius = std::pow(10.0, power)};
            return one_case(inside_body(body, count, random));
          }};
}

/// A body of the size of 0.01 over a ground of two million, both in one tree.
std::vector<HardCase> large_world(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 14);
  const Vec3 center{300, 5, -200};
  HardCase result =
      inside_body({.segments = kSegments, .radius = 0.01, .center = center}, share(count, 0, 2), random);
  result.scene.meshes.push_back(make_sheet(8, 1, 1e6, {0, -1e5 * 3, 0}));
  Scene outside = result.scene;
  std::vector<HardCase> cases = one_case(std::move(result));
  cases.push_back(seen_from(std::move(outside), center, 0.1, share(count, 1, 2), random));
  return cases;
}

/// At a body of size 1 from a cube of half-width `distance` about it.
HardFamily seen_from_distance(std::string_view name, std::string_view description, double distance) {
  return {
      .name = std::string(name),
      .description = std::string(description),
      .make = [distance](std::size_t count, std::uint64_t seed) {
        Pcg32 random(seed, 15);
        return one_case(seen_from(one_mesh(make_body({.segments = kSegments})), {}, distance, count, random));
      }};
}

/// Origins off a triangle's plane by 1e-2 to 1e-7 of its distance from the centre, within the body or not.
std::vector<HardCase> close_origins(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 16);
  HardCase result{.scene = one_mesh(make_body({.segments = kSegments}))};
  const Mesh& mesh = result.scene.meshes.front();
  const TimeChoice time = mixed_times(mesh);
  while (result.rays.size() < count) {
    const float t = time(random);
    const auto prim = static_cast<std::size_t>(random.uniform() * static_cast<double>(mesh.triangle_count()));
    const double nearness = std::pow(10.0, -random.uniform(2, 7)) * (random.uniform() < 0.5 ? -1 : 1);
    const Vec3 origin = point_on(mesh, prim, t, Place::kInside, random) * (1 + nearness);
    const Place place = result.rays.size() % 2 == 0 ? Place::kInside : Place::kEdge;
    const Ray ray = aimed_ray(origin, point_on(mesh, prim, t, place, random), t);
    if (ray.direction.x != 0 || ray.direction.y != 0 || ray.direction.z != 0) result.rays.push_back(ray);
  }
  return one_case(std::move(result));
}

}  // namespace

void add_scale_families(std::vector<HardFamily>& families) {
  for (int power = 3; power <= 7; ++power) families.push_back(far_inside(power));
  for (int power = 3; power <= 7; ++power) families.push_back(far_view(power));
  for (int power = 3; power <= 7; ++power) families.push_back(far_sheet(power));
  for (const int power : {-20, -15, -10, -5, 5, 10, 15, 18}) families.push_back(scaled(power));
  families.push_back({.name = "large-world",
                      .description = "A closed body of size 0.01 above a ground of two million.",
                      .make = large_world});
  families.push_back(seen_from_distance("origin-far", "A body of size 1 from up to a million away.", 1e6));
  families.push_back(
      seen_from_distance("origin-anywhere", "A body of size 1 from points in and about it.", 1.5));
  families.push_back({.name = "origin-close",
                      .description = "From points 1e-2 to 1e-7 off a body's surface at that surface.",
                      .make = close_origins});
}

}  // namespace stbvh::harness
