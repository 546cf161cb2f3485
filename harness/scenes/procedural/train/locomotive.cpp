// The steam engine of the train scene: boiler, cab, wheels and rods.
#include <algorithm>

#include "harness/scenes/procedural/train/train_pieces.h"

namespace stbvh::harness {
namespace {

constexpr double kBoilerHeight = 2.55;
constexpr double kBoilerRadius = 0.85;
constexpr double kCrank = 0.36;     // crank pin from the axle
constexpr double kRodLength = 3.1;  // connecting rod
constexpr std::array<double, 3> kDrivers{-2.1, 0.0, 2.1};
constexpr double kMainDriver = kDrivers[1];

void add_boiler(TrainParts& train, const Motion& body) {
  const auto along = [](double x) { return Vec3{x, kBoilerHeight, 0}; };
  const Placement place{{}, body, 1};
  train[Paint::kGreen].add(cylinder(along(-4.0), along(4.5), kBoilerRadius, kBoilerRadius, false, 16), place);
  for (const double x : {-2.4, -0.7, 1.0, 2.7, 4.45}) {
    train[Paint::kBrass].add(
        cylinder(along(x), along(x + 0.09), kBoilerRadius + 0.02, kBoilerRadius + 0.02, false, 16), place);
  }
  // Smokebox with a domed door, its hinges and handle.
  train[Paint::kBlack].add(cylinder(along(4.5), along(6.0), 0.92, 0.92, true, 16), place);
  const Rigid door = along_axis(along(6.0), {1, 0, 0});
  train[Paint::kBlack].add(
      smooth_lathe(
          [](double v) {
            return ProfilePoint{0.74 * std::sin(kPi / 2 * v), 0.16 * std::cos(kPi / 2 * v)};
          },
          0.74, 0.8, 16, 4),
      {door, body, 1});
  train[Paint::kSteel].add(torus(along(6.01), {1, 0, 0}, 0.76, 0.035, 20, 6), place);
  train[Paint::kBrass].add(cylinder(along(6.12), along(6.3), 0.07, 0.05), place);
  train[Paint::kSteel].add(box({6.22, kBoilerHeight, 0}, {0.02, 0.03, 0.33}), place);
  train[Paint::kSteel].add(box({6.26, kBoilerHeight, 0}, {0.02, 0.28, 0.03}), place);
  // Chimney, domes, whistle.
  train[Paint::kBlack].add(
      lathe({{0.36, 3.3}, {0.26, 3.55}, {0.3, 4.25}, {0.42, 4.35}, {0.42, 4.47}, {0.3, 4.47}, {0.24, 3.6}},
            16),
      {translation({5.3, 0, 0}), body, 1.4});
  const auto dome = [](double r, double h) {
    return smooth_lathe(
        [=](double v) {
          const double bell = v < 0.5 ? 1 : std::cos(kPi * (v - 0.5));
          return ProfilePoint{r * (bell + 0.35 * std::exp(-14 * v)),
                              h * (v < 0.5 ? v : 0.5 + 0.5 * std::sin(kPi * (v - 0.5)))};
        },
        r, 1.6 * h, 14, 6);
  };
  train[Paint::kBrass].add(dome(0.40, 0.85), {translation({2.0, 3.28, 0}), body, 1.4});
  train[Paint::kGreen].add(dome(0.34, 0.65), {translation({3.7, 3.3, 0}), body, 1.4});
  train[Paint::kBrass].add(cylinder({-2.9, 3.4, 0.3}, {-2.9, 3.85, 0.3}, 0.05, 0.07), {{}, body, 2});
}

void add_cab(TrainParts& train, const Motion& body) {
  const Placement place{{}, body, 1};
  Part& green = train[Paint::kGreen];
  green.add(box({-3.3, 2.35, 0}, {0.75, 0.95, 0.98}), place);  // firebox
  for (const double z : {-1.38, 1.38}) {                       // side with a window
    green.add(box({-4.9, 2.15, z}, {0.95, 0.55, 0.03}), place);
    green.add(box({-4.9, 3.72, z}, {0.95, 0.2, 0.03}), place);
    for (const double x : {-5.75, -4.9, -4.05}) green.add(box({x, 3.1, z}, {0.1, 0.45, 0.03}), place);
    train[Paint::kBrass].add(box({-4.9, 2.72, z}, {0.97, 0.03, 0.05}), place);
  }
  green.add(box({-3.98, 2.15, 0}, {0.03, 0.55, 1.38}), place);  // front, with two windows
  green.add(box({-3.98, 3.72, 0}, {0.03, 0.2, 1.38}), place);
  for (const double z : {-1.25, 0.0, 1.25})
    green.add(box({-3.98, 3.1, z}, {0.03, 0.45, z == 0 ? 0.85 : 0.13}), place);
  train[Paint::kBlack].add(
      sheet(
          [](double u, double v) {
            const double side = 2 * v - 1;
            return Vec3{lerp(-6.1, -3.7, u), 3.92 + 0.36 * (1 - side * side), 1.52 * side};
          },
          2.4, 3.2, 2, 8),
      place);
  train[Paint::kBlack].add(box({-5.0, 1.58, 0}, {1.1, 0.06, 1.4}), place);
  // Driver at the window: a head, a cap, a body.
  train[Paint::kBlack].add(ellipsoid({-4.5, 2.75, 1.0}, {0.22, 0.42, 0.26}, 10, 8), {{}, body, 1.5});
  train[Paint::kCream].add(ellipsoid({-4.5, 3.22, 1.08}, {0.13, 0.16, 0.13}, 10, 8), {{}, body, 2});
  train[Paint::kCoal].add(ellipsoid({-4.47, 3.34, 1.08}, {0.18, 0.06, 0.15}, 10, 6), {{}, body, 2});
}

void add_front(TrainParts& train, const Motion& body) {
  const Placement place{{}, body, 1};
  train[Paint::kRed].add(box({6.5, 1.15, 0}, {0.08, 0.2, 1.4}), place);
  for (const double z : {-0.85, 0.85}) {
    train[Paint::kBlack].add(cylinder({6.55, 1.2, z}, {6.95, 1.2, z}, 0.1, 0.1), place);
    train[Paint::kSteel].add(cylinder({6.95, 1.2, z}, {7.02, 1.2, z}, 0.24, 0.24, true, 14), place);
  }
  for (int i = -7; i <= 7; ++i) {  // cowcatcher: bars that meet in a wedge
    const double z = 0.17 * i;
    const double reach = 7.5 - 0.09 * std::abs(i);
    train[Paint::kRed].add(cylinder({6.6, 0.98, 0.85 * z}, {reach, 0.16, z}, 0.04, 0.04, false, 5),
                           {{}, body, 1.5});
  }
  for (const double side : {-1.0, 1.0}) {
    train[Paint::kRed].add(cylinder({7.55, 0.16, 0}, {6.85, 0.16, 1.2 * side}, 0.05, 0.05, true, 6), place);
  }
  // Headlamp on the smokebox.
  train[Paint::kBlack].add(cylinder({5.95, 3.62, 0}, {6.3, 3.62, 0}, 0.2, 0.24, true, 14), place);
  train[Paint::kCream].add(disc({6.31, 3.62, 0}, {1, 0, 0}, 0.2, 14), place);
  train[Paint::kBrass].add(torus({6.31, 3.62, 0}, {1, 0, 0}, 0.22, 0.03, 16, 6), place);
}

void add_frame(TrainParts& train, const Motion& body) {
  const Placement place{{}, body, 1};
  for (const double z : {-1.0, 1.0}) {
    const double outside = z > 0 ? 1.0 : -1.0;
    train[Paint::kBlack].add(box({0.6, 1.82, 1.15 * z}, {5.4, 0.04, 0.32}), place);  // running board
    train[Paint::kRed].add(box({0.6, 1.76, 1.15 * z + 0.33 * outside}, {5.4, 0.07, 0.015}), place);
    train[Paint::kBlack].add(box({0.4, 1.2, 0.58 * z}, {5.9, 0.32, 0.03}), place);  // frame plate
    train[Paint::kBrass].add(tube(
                                 [z](double s) {
                                   return Vec3{lerp(-3.6, 5.8, s), 2.95, 0.93 * z};
                                 },
                                 9.4, 0.025, {0, 1, 0}, 6, 8),
                             place);
    for (int i = 0; i < 6; ++i) {
      const double x = -3.2 + 1.75 * i;
      train[Paint::kBrass].add(cylinder({x, 2.93, 0.78 * z}, {x, 2.95, 0.94 * z}, 0.025, 0.025, false, 5),
                               place);
    }
    for (const double x : kDrivers) {  // splashers over the driving wheels
      train[Paint::kGreen].add(sheet(
                                   [=](double u, double v) {
                                     const double angle = kPi * (0.12 + 0.76 * u);
                                     return Vec3{x + 1.06 * std::cos(angle), 0.95 + 1.06 * std::sin(angle),
                                                 z * lerp(0.62, 0.92, v)};
                                   },
                                   2.6, 0.3, 10, 1),
                               place);
    }
    train[Paint::kSteel].add(cylinder({3.6, 1.95, 0.98 * z}, {3.6, 2.4, 0.98 * z}, 0.13, 0.13, true, 10),
                             place);  // pump
  }
}

/// Where the crank pin of a side is, from the axle; the two sides are a quarter turn apart.
Vec3 crank_pin(double side, double time) {
  const double angle = (side > 0 ? -0.55 : -0.55 + kPi / 2) - kTravel / kDriverRadius * time;
  return {kCrank * std::cos(angle), kCrank * std::sin(angle), 0};
}

/// Distance of the crosshead from the main axle, with the pin at `pin`.
double crosshead(Vec3 pin) {
  return pin.x + std::sqrt(kRodLength * kRodLength - pin.y * pin.y);
}

void add_rods_of(TrainParts& train, double side, const Motion& body) {
  const double y = kDriverRadius;
  const double z = side * (kHalfGauge + 0.2);
  Part& steel = train[Paint::kSteel];
  const Motion circling = rigid_motion([side](double time) { return translation(crank_pin(side, time)); });
  for (std::size_t i = 0; i + 1 < kDrivers.size(); ++i) {
    const double middle = 0.5 * (kDrivers[i] + kDrivers[i + 1]);
    steel.add(box({middle, y, z}, {1.05, 0.075, 0.03}), {{}, circling, 2});
  }
  for (const double x : kDrivers) {
    steel.add(cylinder({x, y, z - 0.06}, {x, y, z + 0.06}, 0.15, 0.15, true, 12), {{}, circling, 2});
    train[Paint::kBrass].add(cylinder({x, y, z + 0.06 * side}, {x, y, z + 0.16 * side}, 0.06, 0.06, true, 8),
                             {{}, circling, 2});
  }
  const Motion connecting = rigid_motion([=](double time) {
    const Vec3 pin = crank_pin(side, time);
    return translation(pin + Vec3{kMainDriver, y, z + 0.12 * side}) *
           rotation({0, 0, 1}, std::asin(-pin.y / kRodLength));
  });
  steel.add(box({0.5 * kRodLength, 0, 0}, {0.5 * kRodLength, 0.07, 0.03}), {{}, connecting, 2});
  for (const double x : {0.0, kRodLength}) {
    steel.add(cylinder({x, 0, -0.05}, {x, 0, 0.05}, 0.16, 0.16, true, 12), {{}, connecting, 2});
  }
  const Motion sliding = rigid_motion([=](double time) {
    return translation({kMainDriver + crosshead(crank_pin(side, time)), y, z + 0.12 * side});
  });
  steel.add(box({0, 0, 0}, {0.16, 0.15, 0.07}), {{}, sliding, 2});
  steel.add(cylinder({0.1, 0, 0}, {1.3, 0, 0}, 0.04, 0.04, true, 8), {{}, sliding, 2});
  // Cylinder and slide bars stay with the frame.
  const Vec3 back{4.05, y, z + 0.12 * side}, front{5.25, y, z + 0.12 * side};
  train[Paint::kGreen].add(cylinder(back, front, 0.36, 0.36, true, 16), {{}, body, 1});
  train[Paint::kBrass].add(torus(front, {1, 0, 0}, 0.34, 0.04, 16, 5), {{}, body, 1});
  train[Paint::kBlack].add(box((back + front) * 0.5 + Vec3{0, 0.5, 0}, {0.5, 0.16, 0.25}), {{}, body, 1});
  for (const double dy : {-0.2, 0.2}) {
    steel.add(box({3.3, y + dy, z + 0.12 * side}, {0.8, 0.03, 0.06}), {{}, body, 1});
  }
}

}  // namespace

void add_rods(TrainParts& train) {
  for (const double side : {-1.0, 1.0}) add_rods_of(train, side, sway(0.3));
}

void add_locomotive(TrainParts& train, std::uint64_t seed) {
  const Motion body = sway(0.3);
  add_boiler(train, body);
  add_cab(train, body);
  add_front(train, body);
  add_frame(train, body);
  for (const double x : kDrivers) {
    add_axle(train, x, {kDriverRadius, 0.11, 0.14, 14, 0.04, 0.17, 0.24, 0.03}, Paint::kRed, 0.1 * x);
  }
  for (const double x : {3.85, 5.45})
    add_axle(train, x, {0.46, 0.07, 0.13, 10, 0.028, 0.1, 0.2, 0.03}, Paint::kRed, x);
  add_rods(train);
  add_steam(train, seed);
}

void add_steam(TrainParts& train, std::uint64_t seed) {
  Pcg32 random(seed, 11);
  constexpr int kPuffs = 46;
  for (int i = 0; i < kPuffs; ++i) {
    const double age =
        (i + random.uniform(0.0, 0.6)) / kPuffs;  // 0 at the chimney, 1 at the end of the plume
    const double radius = 0.2 + 1.3 * std::pow(age, 0.65) * random.uniform(0.75, 1.2);
    const Vec3 spread{0, random.uniform(-0.5, 0.7), random.uniform(-0.8, 0.8)};
    const double phase = random.uniform(0, 2 * kPi);
    const auto center = [=](double a) {
      return Vec3{5.3 - 23.0 * a * (0.25 + 0.75 * a), 4.5 + 3.6 * std::pow(a, 0.8), 0} +
             spread * std::min(2 * a, 1.2);
    };
    // The plume drifts back as the landscape does, swells and curls.
    const Motion drift = [=](double time) -> PointMap {
      const Vec3 at = center(age + 0.045 * time);
      const double swell = 1 + 0.12 * time;
      const Quaternion curl = axis_angle({0.2, 0.3, 1}, 0.5 * time);
      return [=](Vec3 p) { return at + rotate(curl, p * swell); };
    };
    const auto lumpy = [=](double u, double v) {
      const double angle = kPi * (0.002 + 0.996 * v), turn = 2 * kPi * u;
      const Vec3 d{std::sin(angle) * std::cos(turn), std::cos(angle), std::sin(angle) * std::sin(turn)};
      const double bump = 1 + 0.16 * std::sin(5 * d.x + phase) * std::sin(4 * d.y + 2 * phase) +
                          0.09 * std::sin(9 * d.z + phase) * std::sin(8 * d.x - phase) +
                          0.05 * std::sin(17 * d.y + phase) * std::sin(15 * d.z);
      return d * (radius * bump);
    };
    train[Paint::kSteam].add({{lumpy, 2 * kPi * radius, kPi * radius, 8, 5, Wrap::kU}}, {{}, drift, 0.6});
  }
}

}  // namespace stbvh::harness
