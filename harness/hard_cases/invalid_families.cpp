/// Rays and meshes that are not valid: an answer all the same, and never a crash.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSegments = 4;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// One float of the three.
float& any_of(Vec3f& v, Pcg32& random) {
  float* all[] = {&v.x, &v.y, &v.z};
  return *all[static_cast<std::size_t>(random.uniform() * 3)];
}

using SpoilRay = void (*)(Ray& ray, std::size_t number, Pcg32& random);

/// Rays at a body, from within it and about it, each made invalid: none may hit anything.
HardFamily invalid_rays(std::string_view name, std::string_view description, SpoilRay spoil) {
  return {.name = std::string(name),
          .description = std::string(description),
          .askable = Askable::kDirect,
          .make = [spoil](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 60);
            HardCase result = seen_from(one_mesh(make_body({.segments = kSegments})), {}, 1, count, random);
            result.scene.meshes.push_back(make_static_mesh("still", cut_octahedron(4), {0.7f, 0.7f, 0.7f}));
            result.expected = Expected::kNothing;
            for (std::size_t i = 0; i < count; ++i) spoil(result.rays[i], i, random);
            return one_case(std::move(result));
          }};
}

void spoil_with_nan(Ray& ray, std::size_t number, Pcg32& random) {
  switch (number % 5) {
    case 0:
      any_of(ray.origin, random) = kNan;
      break;
    case 1:
      any_of(ray.direction, random) = kNan;
      break;
    case 2:
      ray.time = kNan;
      break;
    case 3:
      ray.tnear = kNan;
      break;
    default:
      ray.tfar = kNan;
  }
}

void spoil_with_infinity(Ray& ray, std::size_t number, Pcg32& random) {
  const float infinity = number % 2 == 0 ? kInfinity : -kInfinity;
  switch (number / 2 % 3) {
    case 0:
      any_of(ray.origin, random) = infinity;
      break;
    case 1:
      any_of(ray.direction, random) = infinity;
      break;
    default:
      ray.time = infinity;
  }
}

void move_time_outside(Ray& ray, std::size_t number, Pcg32& random) {
  // No denormal: where they are zero to the machine, they are times to it.
  constexpr float kTimes[] = {-0x1p-126f, -1e-7f, 1.0f + 0x1p-23f, 1e30f};
  const std::size_t i = number % 6;
  ray.time = i < 4 ? kTimes[i] : static_cast<float>(random.uniform(1.001, 3) * (i == 4 ? 1 : -1));
}

void empty_direction(Ray& ray, std::size_t number, Pcg32&) {
  const float zero = number % 2 == 0 ? 0.0f : -0.0f;
  ray.direction = {zero, 0.0f, zero};
}

void turn_range(Ray& ray, std::size_t, Pcg32& random) {
  ray.tfar = static_cast<float>(random.uniform(-1, 1));
  ray.tnear = ray.tfar + static_cast<float>(random.uniform(0.001, 2));
}

/// A body in which every third vertex has `value` as a coordinate at one step, whose triangles are left out.
HardFamily invalid_vertices(std::string_view name, float value) {
  return {.name = std::string(name),
          .description = fmt::format("A body in which one vertex in sixty is {} at one step.", value),
          .make = [value](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 61);
            Mesh mesh = make_body({.segments = kSegments});
            for (std::size_t i = 0; i < mesh.steps.front().size(); i += 60) {
              any_of(mesh.steps[i / 60 % mesh.steps.size()][i], random) = value;
            }
            return one_case(seen_from(one_mesh(std::move(mesh)), {}, 2, count, random));
          }};
}

std::vector<HardCase> indices_out_of_range(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 62);
  Mesh mesh = make_body({.segments = kSegments});
  const auto vertices = static_cast<std::uint32_t>(mesh.steps.front().size());
  const std::uint32_t wrong[] = {vertices, vertices + 1, 0x7FFFFFFFu, 0xFFFFFFFFu};
  for (std::size_t i = 0; i < mesh.indices.size(); i += 50) mesh.indices[i] = wrong[i / 50 % 4];
  return one_case(seen_from(one_mesh(std::move(mesh)), {}, 2, count, random));
}

std::vector<HardCase> most_steps(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 63);
  const auto triangle = [](Pcg32& r) { return bending(random_corners(r, random_point(r, 1), 0.3), 0.3, r); };
  return one_case(
      seen_from(one_mesh(make_soup(300, kMaxSceneSteps - 1, random, triangle)), {}, 2, count, random));
}

std::vector<HardCase> too_many_steps(std::size_t, std::uint64_t seed) {
  std::vector<HardCase> cases;
  for (const std::size_t steps : {kMaxSteps + 1, std::size_t{5000}}) {
    Pcg32 random(seed, 64);
    const Body body{.cuts = 2, .segments = steps - 1};
    cases.push_back(seen_from(one_mesh(make_body(body)), {}, 2, 1, random));
    cases.back().expected = Expected::kRefused;
  }
  return cases;
}

}  // namespace

void add_invalid_families(std::vector<HardFamily>& families) {
  families.push_back(invalid_rays("nan-rays", "Rays with a NaN in one of their numbers.", spoil_with_nan));
  families.push_back(
      invalid_rays("infinite-rays", "Rays with an infinite origin, direction or time.", spoil_with_infinity));
  families.push_back(invalid_rays("times-outside", "Rays at times outside [0, 1].", move_time_outside));
  families.push_back(invalid_rays("no-direction", "Rays whose direction is zero.", empty_direction));
  families.push_back(invalid_rays("turned-range", "Rays whose tfar is below tnear.", turn_range));
  families.push_back(invalid_vertices("nan-vertices", kNan));
  families.push_back(invalid_vertices("infinite-vertices", kInfinity));
  families.push_back(invalid_vertices("huge-vertices", 2e18f));
  families.push_back({.name = "indices-out-of-range",
                      .description = "A body in which one index in fifty points past the vertices.",
                      .make = indices_out_of_range});
  families.push_back(
      {.name = "most-steps", .description = "129 steps, the most that Embree takes.", .make = most_steps});
  families.push_back({.name = "too-many-steps",
                      .description = "4,097 and 5,000 steps: an error that says so, nothing built.",
                      .make = too_many_steps});
}

}  // namespace stbvh::harness
