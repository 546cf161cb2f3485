// Tender and carriages of the train scene.
#include "harness/scenes/procedural/train/train_pieces.h"

namespace stbvh::harness {
namespace {

constexpr SpokedWheel kCarriageWheel{0.45, 0.07, 0.12, 8, 0.03, 0.1, 0.2, 0.03};

/// Two axles under a frame at `x`.
void add_bogie(TrainParts& train, double x, const Motion& body) {
  for (const double dx : {-1.05, 1.05})
    add_axle(train, x + dx, kCarriageWheel, Paint::kSteel, 1.7 * (x + dx));
  for (const double z : {-0.98, 0.98}) {
    train[Paint::kBlack].add(box({x, 0.62, z}, {1.5, 0.09, 0.05}), {{}, body, 1});
    for (const double dx : {-1.05, 1.05}) {
      train[Paint::kBlack].add(box({x + dx, 0.45, z + (z > 0 ? 0.04 : -0.04)}, {0.14, 0.17, 0.06}),
                               {{}, body, 1.5});
    }
    for (int i = -1; i <= 1; ++i) {  // springs
      const Vec3 foot{x + 0.2 * i, 0.7, z};
      train[Paint::kSteel].add(
          tube(
              [=](double s) {
                const double angle = 8 * kPi * s;
                return foot + Vec3{0.06 * std::cos(angle), 0.3 * s, 0.06 * std::sin(angle)};
              },
              1.5, 0.015, {0, 1, 0.01}, 3, 10),
          {{}, body, 1});
    }
  }
}

void add_side(TrainParts& train, double x, double side, const Motion& body) {
  const double z = 1.4 * side;
  const Placement place{{}, body, 1};
  constexpr int kWindows = 9;
  constexpr double kPitch = 16.0 / kWindows;
  train[Paint::kMaroon].add(box({x, 1.6, z}, {8.0, 0.55, 0.03}), place);
  train[Paint::kCream].add(box({x, 3.15, z}, {8.0, 0.15, 0.03}), place);
  train[Paint::kBrass].add(box({x, 2.17, z + 0.02 * side}, {8.0, 0.025, 0.03}), place);
  train[Paint::kGlass].add(quad({x - 8, 2.1, z - 0.05 * side}, {x + 8, 2.1, z - 0.05 * side},
                                {x + 8, 3.05, z - 0.05 * side}, {x - 8, 3.05, z - 0.05 * side}),
                           place);
  for (int i = 0; i <= kWindows; ++i) {
    const double at = x - 8 + kPitch * i;
    train[Paint::kCream].add(box({at, 2.58, z}, {0.2, 0.45, 0.035}), place);
    if (i < kWindows) {
      train[Paint::kCream].add(box({at + 0.5 * kPitch, 2.62, z - 0.01 * side}, {0.03, 0.4, 0.02}), place);
      train[Paint::kBrass].add(box({at + 0.5 * kPitch, 1.55, z + 0.035 * side}, {0.6, 0.012, 0.01}), place);
    }
  }
  for (const double dx : {-7.2, 7.2}) {  // grab rails and steps at the doors
    train[Paint::kBrass].add(
        cylinder({x + dx, 1.4, z + 0.08 * side}, {x + dx, 2.5, z + 0.08 * side}, 0.025, 0.025),
        {{}, body, 1.5});
    train[Paint::kBlack].add(box({x + dx, 0.62, z}, {0.4, 0.03, 0.15}), place);
  }
}

void add_carriage_body(TrainParts& train, double x, const Motion& body) {
  const Placement place{{}, body, 1};
  for (const double side : {-1.0, 1.0}) add_side(train, x, side, body);
  for (const double dx : {-8.0, 8.0}) {
    train[Paint::kMaroon].add(box({x + dx, 2.15, 0}, {0.04, 1.1, 1.4}), place);
    train[Paint::kBlack].add(box({x + dx * 1.03, 2.05, 0}, {0.3, 0.95, 0.5}), place);  // bellows
    for (const double z : {-0.85, 0.85}) {
      train[Paint::kSteel].add(cylinder({x + dx, 1.0, z}, {x + dx * 1.055, 1.0, z}, 0.1, 0.18), place);
    }
  }
  train[Paint::kRoof].add(
      sheet(
          [=](double u, double v) {
            const double angle = kPi * v;
            return Vec3{x + 16.3 * (u - 0.5), 3.28 + 0.5 * std::sin(angle), -1.52 * std::cos(angle)};
          },
          16.3, 3.6, 4, 10),
      place);
  for (int i = -3; i <= 3; ++i) {
    train[Paint::kRoof].add(cylinder({x + 2.2 * i, 3.75, 0}, {x + 2.2 * i, 3.98, 0}, 0.14, 0.2, true, 10),
                            place);
  }
  train[Paint::kBlack].add(box({x, 0.97, 0}, {8.0, 0.09, 1.3}), place);
  train[Paint::kBlack].add(box({x, 0.62, 0.7}, {1.4, 0.22, 0.3}), place);  // battery box
}

}  // namespace

void add_carriage(TrainParts& train, double x, double phase) {
  const Motion body = sway(phase);
  add_carriage_body(train, x, body);
  add_bogie(train, x - 5.6, body);
  add_bogie(train, x + 5.6, body);
}

void add_tender(TrainParts& train, double richness, std::uint64_t seed) {
  const Motion body = sway(1.1);
  const Placement place{{}, body, 1};
  train[Paint::kGreen].add(box({-8.8, 1.95, 0}, {2.5, 0.75, 1.35}), place);
  train[Paint::kBlack].add(box({-8.8, 1.1, 0}, {2.6, 0.1, 1.35}), place);
  for (const double z : {-1.36, 1.36}) {
    train[Paint::kBrass].add(box({-8.8, 2.66, z}, {2.5, 0.03, 0.02}), place);
    train[Paint::kBrass].add(box({-8.8, 1.3, z}, {2.4, 0.02, 0.01}), place);
  }
  for (const double x : {-10.2, -7.4}) add_bogie(train, x, body);
  Pcg32 random(seed, 12);
  const int lumps = static_cast<int>(std::lround(260 * richness));
  for (int i = 0; i < lumps; ++i) {  // coal, heaped
    const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
    const double height = 2.7 + 0.75 * (1 - u * u) * (1 - v * v);
    const double r = random.uniform(0.1, 0.2);
    const Rigid pose = translation({-8.8 + 2.3 * u, height, 1.2 * v}) *
                       rotation(normalize(Vec3{u, 0.4, v}), random.uniform(0, 6));
    train[Paint::kCoal].add(ellipsoid({}, {r, 0.7 * r, 0.9 * r}, 5, 3), {pose, body, 1});
  }
}

}  // namespace stbvh::harness
