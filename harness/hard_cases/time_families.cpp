/// Times on the boundaries of segments, of time ranges and of temporal splits.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"

namespace stbvh::harness {
namespace {

HardFamily step_time_family(std::size_t segments) {
  return {.name = fmt::format("step-times-{}", segments),
          .description = fmt::format(
              "A closed body at times exactly on i/{} and one float beside, 0 and 1 among them.", segments),
          .make = [segments](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 2);
            Mesh clock;
            clock.steps.resize(segments + 1);
            return one_case(inside_body({.segments = segments}, step_times(clock), count, random));
          }};
}

std::vector<HardCase> time_ends(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 3);
  const TimeChoice time = [](Pcg32& r) {
    constexpr std::array<float, 5> kTimes{0.0f, 0x1p-149f, 0x1p-126f, 1.0f - 0x1p-24f, 1.0f};
    return kTimes[static_cast<std::size_t>(r.uniform() * kTimes.size())];
  };
  std::vector<HardCase> cases;
  cases.push_back(inside_body({.segments = 7}, time, share(count, 0, 2), random));
  cases.push_back(inside_body({.segments = 128}, time, share(count, 1, 2), random));
  return cases;
}

/// Halving over and over, as a builder splits time: k / 2^n and one float beside.
float split_time(Pcg32& random) {
  const int depth = 1 + static_cast<int>(random.uniform() * 7);
  const double part = std::floor(random.uniform() * std::ldexp(1.0, depth));
  return std::clamp(ulp_around(static_cast<float>(std::ldexp(part, -depth)), random), 0.0f, 1.0f);
}

std::vector<HardCase> temporal_splits(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 4);
  std::vector<HardCase> cases;
  for (std::size_t i = 0; i < 2; ++i) {
    const Body body{.segments = i == 0 ? 128u : 100u, .drift = {20, -15, 10}};
    cases.push_back(inside_body(body, split_time, share(count, i, 2), random));
  }
  return cases;
}

/// Sheets side by side, each on a grid of its own; with `in_turn` each is there in its own part of the
/// shutter only.
Scene sheets(bool in_turn) {
  constexpr std::array<std::size_t, 6> kSegments{3, 5, 7, 13, 1, 128};
  Scene scene;
  scene.name = "sheets";
  for (std::size_t i = 0; i < kSegments.size(); ++i) {
    const Vec3 center{in_turn ? 0.0 : 2.0 * static_cast<double>(i), 0, 0};
    scene.meshes.push_back(make_sheet(16, kSegments[i], 1, center));
    if (!in_turn) continue;
    scene.meshes.back().time_range = {static_cast<float>(i) / 6.0f, static_cast<float>(i + 1) / 6.0f};
  }
  return scene;
}

std::vector<HardCase> rays_on_all_clocks(Scene scene, std::size_t count, Pcg32& random) {
  HardCase result{.scene = std::move(scene)};
  const std::vector<Mesh>& meshes = result.scene.meshes;
  const TimeChoice time = [&](Pcg32& r) {
    const auto i = static_cast<std::size_t>(r.uniform() * static_cast<double>(meshes.size()));
    return step_times(meshes[i])(r);
  };
  const auto origin = [](float, Pcg32& r) { return Vec3{0, 4, 0} + random_point(r, 2); };
  result.rays = rays_at(result.scene, {.time = time, .origin = origin, .beside = true}, count, random);
  return one_case(std::move(result));
}

std::vector<HardCase> grids_touching(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 5);
  return rays_on_all_clocks(sheets(false), count, random);
}

std::vector<HardCase> time_ranges_touching(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 6);
  return rays_on_all_clocks(sheets(true), count, random);
}

Scene inner_time_range() {
  Scene scene = one_mesh(make_body({.segments = 128}));
  scene.meshes.front().time_range = {0.1f, 0.9f};
  return scene;
}

std::vector<HardCase> time_range_alone(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 7);
  return rays_on_all_clocks(inner_time_range(), count, random);
}

/// Something still stands by, so that the scene as a whole is there at all times.
std::vector<HardCase> time_range_inner(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 8);
  Scene scene = inner_time_range();
  scene.meshes.push_back(make_sheet(2, 0, 1, {0, -2, 0}));
  return rays_on_all_clocks(std::move(scene), count, random);
}

}  // namespace

void add_time_families(std::vector<HardFamily>& families) {
  for (const std::size_t segments : {3u, 5u, 7u, 13u, 128u}) families.push_back(step_time_family(segments));
  families.push_back({.name = "time-ends",
                      .description = "A closed body at times 0 and 1 and one float inside.",
                      .make = time_ends});
  families.push_back({.name = "temporal-splits",
                      .description = "A closed body on a long way, at times where a builder halves time.",
                      .make = temporal_splits});
  families.push_back({.name = "grids-touching",
                      .description = "Sheets of 1 to 128 segments side by side, at the steps of all of them.",
                      .make = grids_touching});
  // Embree 3.13.5 stops in an assertion when it splits such time ranges.
  families.push_back({.name = "time-ranges-touching",
                      .description = "Sheets that follow one another in time, at the ends of their ranges.",
                      .askable = Askable::kOurs,
                      .make = time_ranges_touching});
  families.push_back({.name = "time-range-inner",
                      .description = "128 segments over [0.1, 0.9], at the steps and one float outside.",
                      .askable = Askable::kOurs,
                      .make = time_range_inner});
  // Through Embree, a geometry that ends before 1 is not there at its very end
  // (tests/plugin/time_range_test.cpp).
  families.push_back({.name = "time-range-alone",
                      .description = "The same without anything that is there at all times.",
                      .askable = Askable::kDirect,
                      .make = time_range_alone});
}

}  // namespace stbvh::harness
