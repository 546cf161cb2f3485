/// Steps at times of their own, which Embree does not take.
#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"

namespace stbvh::harness {
namespace {

/// Ascending, each once, 0 and 1 among them; at most `steps`.
std::vector<float> random_times(std::size_t steps, Pcg32& random) {
  std::vector<float> times{0, 1};
  while (times.size() < steps) times.push_back(static_cast<float>(random.uniform()));
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

/// `count` floats that follow one another, the first of them `time`.
void add_neighbours(float time, std::size_t count, std::vector<float>& times) {
  for (std::size_t i = 0; i < count; ++i) {
    times.push_back(time);
    time = std::nextafter(time, std::numeric_limits<float>::infinity());
  }
}

std::vector<float> neighbouring_times() {
  std::vector<float> times{0};
  for (const float time : {0x1p-20f, 0.3f, 0.75f}) add_neighbours(time, 6, times);
  times.push_back(std::nextafter(1.0f, 0.0f));
  times.push_back(1);
  return times;
}

/// `count` steps a millionth apart from 0.9 on.
std::vector<float> long_then_short_times(std::size_t count) {
  std::vector<float> times{0};
  for (std::size_t i = 0; i < count; ++i) times.push_back(0.9f + 1e-6f * static_cast<float>(i));
  times.push_back(1);
  return times;
}

/// Seen from inside, at steps and one float beside, or at any time, in turn.
std::vector<HardCase> inside_uneven_body(std::size_t cuts, std::vector<float> times, std::size_t count,
                                         Pcg32& random) {
  const Body body{.cuts = cuts, .segments = times.size() - 1, .turn = 8, .step_times = times};
  Mesh clock;
  clock.steps.resize(times.size());
  clock.step_times = std::move(times);
  const TimeChoice at_steps = step_times(clock), anywhere = mixed_times(clock);
  const TimeChoice time = [=](Pcg32& r) { return r.uniform() < 0.5 ? at_steps(r) : anywhere(r); };
  return one_case(inside_body(body, time, count, random));
}

/// Sheets side by side, each with times of its own: few, many, an ulp apart, there for a part of the shutter,
/// equidistant, and at rest.
Scene uneven_sheets(Pcg32& random) {
  Scene scene;
  scene.name = "sheets";
  const auto add = [&](std::size_t segments, const std::vector<float>& times) {
    const Vec3 center{2.0 * static_cast<double>(scene.meshes.size()), 0, 0};
    scene.meshes.push_back(make_sheet(16, segments, 1, center));
    scene.meshes.back().step_times = times;
  };
  std::vector<float> part = random_times(9, random);
  for (float& time : part) time = 0.2f + 0.5f * time;
  for (const std::vector<float>& times : {random_times(3, random), random_times(14, random),
                                          random_times(200, random), neighbouring_times(), part})
    add(times.size() - 1, times);
  add(7, {});
  add(0, {});
  return scene;
}

std::vector<HardCase> uneven_grids_touching(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 74);
  HardCase result{.scene = uneven_sheets(random)};
  const std::vector<Mesh>& meshes = result.scene.meshes;
  const TimeChoice time = [&](Pcg32& r) {
    return step_times(meshes[static_cast<std::size_t>(r.uniform() * static_cast<double>(meshes.size()))])(r);
  };
  const auto origin = [](float, Pcg32& r) { return Vec3{0, 4, 0} + random_point(r, 2); };
  result.rays = rays_at(result.scene, {.time = time, .origin = origin, .beside = true}, count, random);
  return one_case(std::move(result));
}

std::vector<HardCase> most_own_steps(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 75);
  const auto triangle = [](Pcg32& r) { return bending(random_corners(r, random_point(r, 1), 0.3), 0.3, r); };
  return one_case(seen_from(one_mesh(make_soup(40, kMaxSteps - 1, random, triangle)), {}, 2, count, random));
}

}  // namespace

void add_uneven_families(std::vector<HardFamily>& families) {
  families.push_back({.name = "uneven-17",
                      .description = "A closed body with 17 steps at random times, at these and between.",
                      .make = [](std::size_t count, std::uint64_t seed) {
                        Pcg32 random(seed, 70);
                        return inside_uneven_body(kCuts2k, random_times(17, random), count, random);
                      }});
  families.push_back({.name = "uneven-1000",
                      .description = "The same with 1,000 steps.",
                      .make = [](std::size_t count, std::uint64_t seed) {
                        Pcg32 random(seed, 71);
                        return inside_uneven_body(8, random_times(1000, random), count, random);
                      }});
  families.push_back({.name = "steps-an-ulp-apart",
                      .description = "A closed body that moves as far from one float to the next as between.",
                      .make = [](std::size_t count, std::uint64_t seed) {
                        Pcg32 random(seed, 72);
                        return inside_uneven_body(kCuts2k, neighbouring_times(), count, random);
                      }});
  families.push_back({.name = "one-long-many-short",
                      .description = "A closed body with a segment of 0.9, then 100 of a millionth.",
                      .make = [](std::size_t count, std::uint64_t seed) {
                        Pcg32 random(seed, 73);
                        return inside_uneven_body(kCuts2k, long_then_short_times(101), count, random);
                      }});
  families.push_back({.name = "uneven-grids-touching",
                      .description = "Sheets side by side with unlike times, at the steps of all of them.",
                      .make = uneven_grids_touching});
  families.push_back({.name = "most-own-steps",
                      .description = "4,096 steps, the most that a mesh may have.",
                      .make = most_own_steps});
}

}  // namespace stbvh::harness
