// What flows in the barbershop: hair, cut hair, the pole's stripes, towels.
#include "harness/scenes/procedural/barbershop/shop_pieces.h"

namespace stbvh::harness {
namespace {

/// A hair along a curve, of three sides and eight pieces whatever the resolution.
Patches strand(const std::function<Vec3(double)>& curve, double radius, Vec3 side) {
  return {{[=](double u, double v) {
             const Vec3 tangent = normalize(curve(std::min(v + 0.01, 1.0)) - curve(std::max(v - 0.01, 0.0)));
             const Vec3 depth = normalize(cross(tangent, side));
             const double angle = 2 * kPi * u, r = radius * (1 - 0.7 * v);
             return curve(v) + (depth * std::cos(angle) + cross(depth, tangent) * std::sin(angle)) * r;
           },
           0, 0, 3, 8, Wrap::kU}};
}

/// Few hairs are thick ones: together they cover the same scalp.
double strand_radius(std::size_t strands) {
  return std::min(0.03, std::max(0.0012, 0.18 / std::sqrt(static_cast<double>(strands))));
}

}  // namespace

void add_hair(Barbershop& shop, Vec3 head, const std::function<Rigid(double)>& body, ShopPaint paint,
              std::size_t strands, std::uint64_t seed) {
  Pcg32 random(seed, 42);
  const double radius = strand_radius(strands);
  // Tips lag behind the head and sway.
  const Motion sway = on_dolly(compose(rigid_motion(body), [head](double time) -> PointMap {
    return [=](Vec3 p) {
      const Vec3 out = p - head;
      const double slack = std::max(0.0, length(out) - 0.13) / 0.1;
      const double wave = 2 * kPi * time + 20 * p.x + 14 * p.y;
      return p + Vec3{std::sin(wave), 0.4 * std::cos(wave), std::cos(1.3 * wave)} * (0.012 * slack);
    };
  }));
  for (std::size_t i = 0; i < strands; ++i) {
    const double turn = random.uniform(0, 2 * kPi);
    const double rise = random.uniform(-0.1, 1.0);
    const double flat = std::sqrt(1 - rise * rise);
    const Vec3 out{flat * std::cos(turn), rise, flat * std::sin(turn)};
    const Vec3 root = head + Vec3{0.096 * out.x, 0.133 * out.y, 0.113 * out.z};
    const double forehead = out.z > 0 ? smoothstep(0.55, 0.2, out.y) * out.z : 0;
    const double reach = random.uniform(0.07, 0.12) * (forehead > 0.3 ? 0.0 : 1.0);
    if (reach == 0) {  // not on the face: at the nape instead
      const Vec3 nape = head + Vec3{0.09 * out.x, -0.03 + 0.05 * out.y, -0.105};
      shop.flowing[paint].add(strand(
                                  [=](double s) {
                                    return nape + Vec3{0.03 * out.x * s, -0.07 * s, -0.03 * s};
                                  },
                                  radius, {1, 0, 0.1}),
                              {{}, sway, 1});
      continue;
    }
    const double curl = random.uniform(-0.25, 0.25);
    const Vec3 aside = normalize(cross(out, Vec3{0.1, 1, 0.2}));
    const auto curve = [=](double s) {
      const Vec3 fall = Vec3{0, -0.55 * flat, -0.25} * (s * s);
      return root + (out * (0.55 * s) + fall + aside * (curl * s * s)) * reach;
    };
    shop.flowing[paint].add(strand(curve, radius, perpendicular(out)), {{}, sway, 1});
  }
}

void add_clippings(Barbershop& shop, Vec3 from, std::size_t strands, std::uint64_t seed) {
  Pcg32 random(seed, 43);
  for (std::size_t i = 0; i < strands; ++i) {
    const double turn = random.uniform(0, 2 * kPi), out = random.uniform(0.12, 0.42);
    const Vec3 at = from + Vec3{out * std::cos(turn), random.uniform(-1.5, 0.05), out * std::sin(turn)};
    const double speed = random.uniform(0.1, 0.25), spin = random.uniform(-1.5, 1.5);
    const Vec3 axis = normalize(Vec3{random.uniform(-1, 1), random.uniform(-1, 1), 0.4});
    const double size = random.uniform(0.012, 0.03);
    const Motion falling = on_dolly(rigid_motion([=](double time) {
      const Vec3 drop{0.01 * std::sin(5 * time + turn), -speed * time * (0.4 + 0.6 * time), 0};
      return translation(at + drop) * rotation(axis, turn + spin * time);
    }));
    shop.flowing[ShopPaint::kDarkHair].add(strand(
                                               [size](double s) {
                                                 return Vec3{size * (2 * s - 1), size * s * (1 - s), 0};
                                               },
                                               0.0016, {0, 0, 1}),
                                           {{}, falling, 1});
  }
}

void add_pole(Barbershop& shop, Vec3 foot) {
  constexpr double kBottom = 0.75, kTop = 2.05, kRadius = 0.17;
  const Placement fixed{translation(foot), on_dolly(), 1};
  Part& chrome = shop.furniture[ShopPaint::kChrome];
  chrome.add(lathe({{0.34, 0},
                    {0.34, 0.05},
                    {0.08, 0.12},
                    {0.06, kBottom - 0.2},
                    {0.2, kBottom - 0.12},
                    {0.21, kBottom},
                    {0.0, kBottom}},
                   24),
             fixed);
  chrome.add(lathe({{0.0, kTop}, {0.21, kTop}, {0.2, kTop + 0.12}, {0.08, kTop + 0.17}}, 24), fixed);
  shop.furniture[ShopPaint::kWhite].add(ellipsoid({0, kTop + 0.33, 0}, {0.19, 0.19, 0.19}, 20, 12), fixed);
  const Motion turning = on_dolly(rigid_motion([foot](double time) {
    return translation(foot) * rotation({0, 1, 0}, 0.42 * time);
  }));
  constexpr std::array<ShopPaint, 8> kStripes{ShopPaint::kWhite, ShopPaint::kRed,   ShopPaint::kWhite,
                                              ShopPaint::kBlue,  ShopPaint::kWhite, ShopPaint::kRed,
                                              ShopPaint::kWhite, ShopPaint::kBlue};
  for (std::size_t i = 0; i < kStripes.size(); ++i) {
    const auto stripe = [i](double u, double v) {
      const double angle = 2 * kPi * ((static_cast<double>(i) + u) / 8 + 1.1 * v);
      return Vec3{kRadius * std::cos(angle), lerp(kBottom, kTop, v), kRadius * std::sin(angle)};
    };
    shop.flowing[kStripes[i]].add(sheet(stripe, 2 * kPi * kRadius / 8, kTop - kBottom, 2, 24),
                                  {{}, turning, 2});
  }
}

void add_towels(Barbershop& shop) {
  const double x = -4.05, y = 1.55;
  const Placement fixed{{}, on_dolly(), 1};
  shop.furniture[ShopPaint::kChrome].add(cylinder({x, y, -1.8}, {x, y, -0.2}, 0.018, 0.018, true, 8), fixed);
  for (int i = 0; i < 3; ++i) {
    const double z = -1.5 + 0.5 * i;
    const double phase = 1.3 * i;
    const auto cloth = [=](double u, double v) {
      const double hang = 0.62 * std::abs(2 * v - 1.1);
      const double side = v > 0.55 ? 1 : -1;
      return Vec3{x + 0.03 * side + 0.02 * hang * std::sin(9 * u), y + 0.02 - hang, z + 0.36 * (u - 0.5)};
    };
    const Motion swing = on_dolly([=](double time) -> PointMap {
      return [=](Vec3 p) {
        const double slack = y + 0.02 - p.y;
        const double wave = 2 * kPi * time + phase + 5 * p.z;
        return p + Vec3{0.06 * slack * (1.2 + std::sin(wave)), 0, 0.03 * slack * std::cos(wave)};
      };
    });
    shop.flowing[i == 1 ? ShopPaint::kRed : ShopPaint::kTowel].add(sheet(cloth, 0.36, 1.25, 10, 24),
                                                                   {{}, swing, 1.2});
  }
}

}  // namespace stbvh::harness
