// Floor, walls and furniture of the barbershop, lamps and fan.
#include "harness/scenes/procedural/barbershop/shop_pieces.h"
#include "harness/scenes/procedural/shared/spoked_wheel.h"

namespace stbvh::harness {
namespace {

constexpr double kHalfRoom = 4.2;   // along x
constexpr double kBackWall = -2.4;  // z
constexpr double kFront = 4.2;
constexpr double kWallHeight = 3.3;

void add_floor_and_walls(ShopParts& parts, const Placement& place) {
  constexpr double kTile = 0.6;
  const Placement coarse{{}, place.motion, 0.5};
  for (int i = 0; i < 14; ++i) {
    for (int j = 0; j < 11; ++j) {
      const double x = -kHalfRoom + kTile * i, z = kBackWall + kTile * j;
      parts[(i + j) % 2 == 0 ? ShopPaint::kWhite : ShopPaint::kBlack].add(
          quad({x, 0, z + kTile}, {x + kTile, 0, z + kTile}, {x + kTile, 0, z}, {x, 0, z}), coarse);
    }
  }
  const double middle = 0.5 * (kBackWall + kFront), half = 0.5 * (kFront - kBackWall);
  parts[ShopPaint::kWall].add(
      box({0, 0.5 * kWallHeight, kBackWall - 0.06}, {kHalfRoom, 0.5 * kWallHeight, 0.06}), coarse);
  parts[ShopPaint::kWood].add(box({0, 0.5, kBackWall + 0.01}, {kHalfRoom, 0.5, 0.02}), coarse);
  for (const double side : {-1.0, 1.0}) {
    const double x = side * (kHalfRoom + 0.06);
    parts[ShopPaint::kWall].add(box({x, 0.5 * kWallHeight, middle}, {0.06, 0.5 * kWallHeight, half}), coarse);
    parts[ShopPaint::kWood].add(box({x - 0.07 * side, 0.5, middle}, {0.02, 0.5, half}), coarse);
    parts[ShopPaint::kWood].add(box({x - 0.08 * side, 1.02, middle}, {0.04, 0.03, half}), place);
    for (int k = 0; k < 8; ++k) {
      parts[ShopPaint::kWood].add(box({x - 0.08 * side, 0.5, kBackWall + 0.4 + 0.8 * k}, {0.035, 0.48, 0.04}),
                                  place);
    }
  }
  for (const double z : {-1.6, 1.6}) {  // beams that carry lamps and fan
    parts[ShopPaint::kWood].add(box({0, kWallHeight - 0.1, z}, {kHalfRoom, 0.1, 0.08}), place);
  }
}

/// A bottle of one of four shapes, on its foot.
void add_bottle(ShopParts& parts, Vec3 foot, Pcg32& random, const Motion& motion) {
  constexpr std::array<ShopPaint, 5> kPaints{ShopPaint::kGreenGlass, ShopPaint::kAmberGlass, ShopPaint::kBlue,
                                             ShopPaint::kWhite, ShopPaint::kRed};
  const ShopPaint paint = kPaints[random.next() % kPaints.size()];
  const double r = random.uniform(0.035, 0.06), h = random.uniform(0.12, 0.26), neck = 0.35 * r;
  const Placement place{translation(foot), motion, 1.5};
  parts[paint].add(lathe({{0.9 * r, 0}, {r, 0.05 * h}, {r, 0.6 * h}, {neck, 0.78 * h}, {neck, 0.95 * h}}, 8),
                   place);
  parts[random.uniform() < 0.5 ? ShopPaint::kChrome : ShopPaint::kBlack].add(
      lathe({{1.3 * neck, 0.93 * h}, {1.2 * neck, 1.1 * h}, {0, 1.1 * h}}, 8), place);
}

void add_counter(ShopParts& parts, const Placement& place, Pcg32& random) {
  constexpr double kTop = 0.92;
  parts[ShopPaint::kWood].add(box({0, 0.5 * kTop - 0.02, kBackWall + 0.28}, {3.6, 0.5 * kTop - 0.04, 0.24}),
                              place);
  parts[ShopPaint::kWhite].add(box({0, kTop, kBackWall + 0.3}, {3.7, 0.03, 0.3}), place);
  for (int i = -4; i <= 4; ++i) {  // drawers
    parts[ShopPaint::kWood].add(box({0.78 * i, 0.62, kBackWall + 0.53}, {0.35, 0.18, 0.02}), place);
    parts[ShopPaint::kWood].add(box({0.78 * i, 0.24, kBackWall + 0.53}, {0.35, 0.16, 0.02}), place);
    parts[ShopPaint::kBrass].add(ellipsoid({0.78 * i, 0.65, kBackWall + 0.57}, {0.03, 0.03, 0.03}, 7, 4),
                                 {{}, place.motion, 2});
  }
  for (int i = 0; i < 40; ++i) {
    const double x = -3.5 + 0.178 * i + random.uniform(-0.03, 0.03);
    add_bottle(parts, {x, kTop + 0.03, kBackWall + random.uniform(0.14, 0.5)}, random, place.motion);
  }
}

void add_mirrors(ShopParts& parts, const Placement& place) {
  for (const double x : {-2.3, 0.0, 2.3}) {
    constexpr double kMiddle = 1.72, kHalfWidth = 0.72, kHalfHeight = 0.6;
    const double z = kBackWall + 0.03;
    parts[ShopPaint::kMirror].add(box({x, kMiddle, z}, {kHalfWidth, kHalfHeight, 0.015}), place);
    for (const double side : {-1.0, 1.0}) {
      parts[ShopPaint::kBrass].add(box({x + side * kHalfWidth, kMiddle, z}, {0.05, kHalfHeight + 0.05, 0.04}),
                                   place);
      parts[ShopPaint::kBrass].add(box({x, kMiddle + side * kHalfHeight, z}, {kHalfWidth, 0.05, 0.04}),
                                   place);
      for (int k = -2; k <= 2; ++k) {  // bulbs
        parts[ShopPaint::kWhite].add(ellipsoid({x + side * (kHalfWidth + 0.0), kMiddle + 0.25 * k, z + 0.07},
                                               {0.045, 0.045, 0.045}, 8, 5),
                                     {{}, place.motion, 2});
      }
    }
  }
}

/// "BARBER" in letters of small blocks on the back wall.
void add_sign(ShopParts& parts, const Placement& place) {
  using Glyph = std::array<unsigned, 7>;  // rows from the top, 5 bits each
  constexpr Glyph kB{0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110};
  constexpr Glyph kA{0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001};
  constexpr Glyph kR{0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001};
  constexpr Glyph kE{0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111};
  constexpr std::array<Glyph, 6> kWord{kB, kA, kR, kB, kE, kR};
  constexpr double kBlock = 0.075;
  double x = -0.5 * kBlock * (6 * 6 - 1);
  for (const Glyph& glyph : kWord) {
    for (int row = 0; row < 7; ++row) {
      for (int column = 0; column < 5; ++column) {
        if ((glyph[static_cast<std::size_t>(row)] >> (4 - column) & 1u) == 0) continue;
        const Vec3 at{x + kBlock * (column + 0.5), 3.08 - kBlock * row, kBackWall + 0.04};
        parts[ShopPaint::kRed].add(box(at, {0.5 * kBlock, 0.5 * kBlock, 0.04}), place);
      }
    }
    x += 6 * kBlock;
  }
}

}  // namespace

void add_room(Barbershop& shop, std::uint64_t seed) {
  Pcg32 random(seed, 41);
  const Placement place{{}, on_dolly(), 1};
  ShopParts& parts = shop.furniture;
  add_floor_and_walls(parts, place);
  add_counter(parts, place, random);
  add_mirrors(parts, place);
  add_sign(parts, place);
  // Bench for those who wait, along the left wall, and a clock above it.
  parts[ShopPaint::kWood].add(box({-3.8, 0.42, 1.0}, {0.3, 0.04, 1.1}), place);
  for (const double z : {0.0, 2.0})
    parts[ShopPaint::kBlack].add(box({-3.8, 0.2, z}, {0.26, 0.2, 0.04}), place);
  for (int k = 0; k < 3; ++k)
    parts[ShopPaint::kLeather].add(cushion({-3.8, 0.52, 0.28 + 0.72 * k}, {0.29, 0.08, 0.34}), place);
  const Rigid clock = translation({-kHalfRoom + 0.04, 2.3, 0.6}) * rotation({0, 1, 0}, kPi / 2);
  parts[ShopPaint::kWhite].add(disc({}, {0, 0, 1}, 0.3, 20), {clock, place.motion, 1});
  parts[ShopPaint::kBlack].add(torus({}, {0, 0, 1}, 0.3, 0.03, 24, 6), {clock, place.motion, 1});
  parts[ShopPaint::kBlack].add(box({0, 0.09, 0.02}, {0.012, 0.09, 0.01}), {clock, place.motion, 2});
  parts[ShopPaint::kBlack].add(box({0.1, 0, 0.02}, {0.12, 0.01, 0.01}), {clock, place.motion, 2});
}

void add_lamps_and_fan(Barbershop& shop) {
  ShopParts& parts = shop.turning;
  for (const double x : {-2.3, 2.3}) {  // lamps that swing
    const Vec3 hook{x, 3.1, -1.6};
    const Motion swing = on_dolly(rigid_motion([=](double time) {
      return rotation_about(hook, {0, 0, 1}, 0.16 * std::sin(0.6 * kPi * time + x));
    }));
    const Placement place{translation(hook), swing, 1};
    parts[ShopPaint::kBlack].add(cylinder({0, -0.45, 0}, {0, 0, 0}, 0.012, 0.012, false, 5), place);
    parts[ShopPaint::kBrass].add(
        smooth_lathe(
            [](double v) {
              return ProfilePoint{0.05 + 0.2 * std::sin(kPi / 2 * v), -0.45 - 0.17 * v * v};
            },
            0.2, 0.35, 16, 6),
        place);
    parts[ShopPaint::kWhite].add(ellipsoid({0, -0.58, 0}, {0.08, 0.1, 0.08}, 10, 6), place);
  }
  const Vec3 hub{0.9, 3.0, 1.6};
  const Motion turning = on_dolly(rigid_motion([=](double time) {
    return rotation_about(hub, {0, 1, 0}, 1.0 * time);
  }));
  parts[ShopPaint::kBlack].add(cylinder({0, 0, 0}, {0, 0.2, 0}, 0.03, 0.03, false, 8),
                               {translation(hub), turning, 1});
  parts[ShopPaint::kBrass].add(ellipsoid({}, {0.14, 0.1, 0.14}, 14, 8), {translation(hub), turning, 1});
  for (int i = 0; i < 4; ++i) {
    const Rigid pose = translation(hub) * rotation({0, 1, 0}, 0.5 * kPi * i) * rotation({1, 0, 0}, 0.2);
    parts[ShopPaint::kWood].add(box({0.56, 0, 0}, {0.44, 0.012, 0.09}), {pose, turning, 1});
  }
}

}  // namespace stbvh::harness
