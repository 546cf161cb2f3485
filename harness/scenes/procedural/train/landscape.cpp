// What the train goes through: track, meadow, trees, telegraph poles. All of it moves back in a straight
// line.
#include <algorithm>

#include "harness/scenes/procedural/train/train_pieces.h"

namespace stbvh::harness {
namespace {

struct Landscape {
  Part meadow, ballast, wood, rail, leaves;
  Motion passing;
};

double ground_height(double x, double z) {
  const double hill =
      smoothstep(22, 90, -z) * (7.5 + 3.0 * std::sin(0.045 * x + 1.0) + 1.6 * std::sin(0.11 * x + 0.05 * z));
  const double bumps = 0.12 * std::sin(0.7 * x + 0.4 * z) * std::sin(0.9 * z - 0.2 * x);
  return -0.75 + hill + bumps * smoothstep(3, 6, std::abs(z));
}

void add_track(Landscape& land) {
  constexpr double kBegin = -80, kEnd = 30;
  const Placement place{{}, land.passing, 1};
  land.ballast.add(sheet(
                       [](double u, double v) {
                         const double x = lerp(kBegin, kEnd, u), z = lerp(-2.6, 2.6, v);
                         const double grit = 0.03 * std::sin(31 * x) * std::sin(27 * z + 3 * x);
                         return Vec3{x, -0.22 - 0.6 * smoothstep(1.5, 2.6, std::abs(z)) + grit, z};
                       },
                       kEnd - kBegin, 5.2, 20, 6),
                   {{}, land.passing, 1.5});
  for (double x = kBegin; x < kEnd; x += 0.7) land.wood.add(box({x, -0.18, 0}, {0.13, 0.07, 1.3}), place);
  for (const double z : {-kHalfGauge, kHalfGauge}) {
    const double middle = 0.5 * (kBegin + kEnd), half = 0.5 * (kEnd - kBegin);
    land.rail.add(box({middle, -0.02, z}, {half, 0.02, 0.035}), place);
    land.rail.add(box({middle, -0.07, z}, {half, 0.05, 0.012}), place);
  }
}

void add_tree(Landscape& land, Vec3 foot, double height, Pcg32& random) {
  land.wood.add(cylinder(foot, foot + Vec3{0, 0.45 * height, 0}, 0.05 * height, 0.025 * height, false, 6),
                {{}, land.passing, 0.5});
  for (int i = 0; i < 6; ++i) {
    const double r = height * random.uniform(0.14, 0.26);
    const Vec3 at =
        foot +
        Vec3{random.uniform(-0.22, 0.22), random.uniform(0.45, 0.85), random.uniform(-0.22, 0.22)} * height;
    const double phase = random.uniform(0, 6);
    const auto crown = [=](double u, double v) {
      const double angle = kPi * (0.002 + 0.996 * v), turn = 2 * kPi * u;
      const Vec3 d{std::sin(angle) * std::cos(turn), std::cos(angle), std::sin(angle) * std::sin(turn)};
      const double bump = 1 + 0.2 * std::sin(7 * d.x + phase) * std::sin(6 * d.y) +
                          0.12 * std::sin(13 * d.z + 11 * d.y + phase);
      return at + d * (r * bump);
    };
    land.leaves.add({{crown, 2 * kPi * r, kPi * r, 6, 4, Wrap::kU}}, {{}, land.passing, 0.4});
  }
}

void add_poles(Landscape& land) {
  constexpr double kPitch = 16, kHeight = 6.4, kZ = -6.5, kFence = 3.6;
  for (int i = -5; i <= 1; ++i) {
    const double x = kPitch * i + 3;
    land.wood.add(cylinder({x, -0.8, kZ}, {x, kHeight, kZ}, 0.14, 0.1, true, 8), {{}, land.passing, 1});
    land.wood.add(box({x, kHeight - 0.4, kZ}, {0.06, 0.06, 0.9}), {{}, land.passing, 1});
    for (const double dz : {-0.8, 0.8}) {
      const auto wire = [=](double s) {
        return Vec3{x + kPitch * s, kHeight - 0.25 - 0.9 * 4 * s * (1 - s) * 0.5, kZ + dz};
      };
      land.rail.add(tube(wire, kPitch, 0.015, {0, 0, 1}, 3, 5), {{}, land.passing, 0.6});
    }
  }
  for (double x = -70; x < 24; x += kFence) {  // fence on the near side of the hill
    land.wood.add(box({x, -0.1, -12}, {0.07, 0.6, 0.07}), {{}, land.passing, 1});
    land.wood.add(box({x + 0.5 * kFence, 0.1, -12}, {0.5 * kFence, 0.05, 0.02}), {{}, land.passing, 1});
    land.wood.add(box({x + 0.5 * kFence, -0.2, -12}, {0.5 * kFence, 0.05, 0.02}), {{}, land.passing, 1});
  }
}

}  // namespace

std::vector<Part> make_landscape(std::size_t steps, double richness, std::uint64_t seed) {
  const Motion passing = rigid_motion([](double time) { return translation({-kTravel * time, 0, 0}); });
  Landscape land{
      {"meadow", steps, {0.16, 0.27, 0.07}, {}, {}}, {"ballast", steps, {0.30, 0.27, 0.24}, {}, {}},
      {"wood", steps, {0.17, 0.10, 0.055}, {}, {}},  {"rails and wires", steps, {0.30, 0.26, 0.24}, {}, {}},
      {"leaves", steps, {0.07, 0.17, 0.04}, {}, {}}, passing};
  land.meadow.add(sheet(
                      [](double u, double v) {
                        const double x = lerp(-190, 60, u), z = lerp(-110, 30, v);
                        return Vec3{x, ground_height(x, z), z};
                      },
                      250, 140, 16, 10),
                  {{}, passing, 0.25});
  add_track(land);
  add_poles(land);
  Pcg32 random(seed, 13);
  const int trees = static_cast<int>(std::lround(60 * richness));
  for (int i = 0; i < trees; ++i) {
    const double x = random.uniform(-150, 20), z = -random.uniform(17, 80);
    add_tree(land, {x, ground_height(x, z) - 0.2, z}, random.uniform(4.0, 8.0), random);
  }
  return {land.meadow, land.ballast, land.wood, land.rail, land.leaves};
}

}  // namespace stbvh::harness
