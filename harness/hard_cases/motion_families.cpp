/// Motion far beyond the size of what moves.
#include <fmt/format.h>

#include <cmath>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"

namespace stbvh::harness {
namespace {

HardFamily fast_body(std::size_t segments) {
  return {.name = fmt::format("fast-closed-{}", segments),
          .description = fmt::format(
              "From inside a closed body that flies 5,000 times its size in {} segments.", segments),
          .make = [segments](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 40);
            const Body body{.segments = segments, .center = {-2000, 0, 0}, .drift = {4000, 3000, -500}};
            return one_case(inside_body(body, count, random));
          }};
}

/// Triangles of size 0.001 that sway by up to 5.
std::vector<HardCase> fast_soup(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 41);
  const auto triangle = [](Pcg32& r) { return drifting(random_corners(r, random_point(r, 1), 1e-3), 5, r); };
  Scene scene = one_mesh(make_soup(500, 5, random, triangle));
  return one_case(seen_from(std::move(scene), {}, 8, count, random));
}

/// A body that turns by half a turn in each segment: vertices move straight, so that half a turn goes through
/// a point.
std::vector<HardCase> half_turn(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 42);
  std::vector<HardCase> cases;
  for (std::size_t i = 0; i < 2; ++i) {
    const double segments = i == 0 ? 1 : 3;
    const Body body{.segments = static_cast<std::size_t>(segments), .turn = kPi * segments};
    cases.push_back(seen_from(one_mesh(make_body(body)), {}, 2, share(count, i, 2), random));
  }
  return cases;
}

/// Every second ray goes at triangles of the one vertex that moves.
std::vector<HardCase> one_moving_vertex(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 43);
  Body body{.segments = 8, .turn = 0, .bulge = 0};
  HardCase result = inside_body(body, count, random);
  Mesh& mesh = result.scene.meshes.front();
  for (std::size_t k = 0; k < mesh.steps.size(); ++k) {
    const double factor = 1 + 0.5 * std::sin(static_cast<double>(k));
    mesh.steps[k][0] = to_float(to_double(mesh.steps[k][0]) * factor);
  }
  std::vector<std::size_t> around;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    if (mesh.indices[i] == 0) around.push_back(i / 3);
  }
  for (std::size_t i = 0; i < result.rays.size(); i += 2) {
    const std::size_t prim = around[i / 2 % around.size()];
    const Place place = i % 4 == 0 ? Place::kVertex : Place::kEdge;
    const float time = result.rays[i].time;
    result.rays[i] =
        aimed_ray(to_double(result.rays[i].origin), point_on(mesh, prim, time, place, random), time);
  }
  return one_case(std::move(result));
}

}  // namespace

void add_motion_families(std::vector<HardFamily>& families) {
  for (const std::size_t segments : {1u, 16u}) families.push_back(fast_body(segments));
  families.push_back({.name = "fast-soup",
                      .description = "Triangles that sway by thousands of times their size.",
                      .make = fast_soup});
  families.push_back({.name = "half-turn",
                      .description = "A body that turns by half a turn in each segment, through a point.",
                      .make = half_turn});
  families.push_back({.name = "one-moving-vertex",
                      .description = "From inside a still closed body with one moving vertex.",
                      .make = one_moving_vertex});
}

}  // namespace stbvh::harness
