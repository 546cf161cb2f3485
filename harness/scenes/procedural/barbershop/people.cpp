// Chairs, customers and the barber.
#include "harness/scenes/procedural/barbershop/shop_pieces.h"

namespace stbvh::harness {
namespace {

constexpr Vec3 kSeatedHead{0, 1.60, -0.02};

/// A limb of unit-free length between two points that move.
Motion between(std::function<Vec3(double)> from, std::function<Vec3(double)> to) {
  return on_dolly(rigid_motion([from = std::move(from), to = std::move(to)](double time) {
    return along_axis(from(time), to(time) - from(time));
  }));
}

void add_head(ShopParts& parts, Vec3 head, const Motion& motion) {
  const Placement place{{}, motion, 1.3};
  Part& skin = parts[ShopPaint::kSkin];
  skin.add(ellipsoid(head, {0.098, 0.135, 0.115}, 16, 12), place);
  skin.add(ellipsoid(head + Vec3{0, -0.07, 0.035}, {0.07, 0.08, 0.08}, 12, 8), place);  // jaw
  skin.add(ellipsoid(head + Vec3{0, -0.015, 0.12}, {0.018, 0.032, 0.03}, 8, 5), place);
  skin.add(cylinder(head + Vec3{0, -0.24, -0.02}, head + Vec3{0, -0.08, -0.01}, 0.06, 0.055, false, 10),
           place);
  for (const double side : {-1.0, 1.0}) {
    skin.add(ellipsoid(head + Vec3{0.1 * side, -0.01, 0}, {0.015, 0.035, 0.025}, 8, 5), place);
    parts[ShopPaint::kBlack].add(
        ellipsoid(head + Vec3{0.038 * side, 0.025, 0.1}, {0.014, 0.011, 0.012}, 6, 4), place);
    parts[ShopPaint::kDarkHair].add(
        ellipsoid(head + Vec3{0.04 * side, 0.056, 0.102}, {0.025, 0.007, 0.012}, 6, 4), place);
  }
  parts[ShopPaint::kRed].add(ellipsoid(head + Vec3{0, -0.075, 0.108}, {0.028, 0.007, 0.012}, 8, 4), place);
}

/// Falls from the neck over arms and knees; ripples run down it.
Patches make_cape() {
  return {{[](double u, double v) {
             const double angle = 2 * kPi * u;
             const double front = 0.5 + 0.5 * std::sin(angle);  // 1 towards the knees
             const double drop = v < 0.3 ? 0.10 * v / 0.3 : 0.10 + (v - 0.3) / 0.7 * lerp(0.62, 0.34, front);
             const double knees = front * front * smoothstep(0.25, 0.75, v) * 0.42;
             const double fold = 1 + 0.07 * v * std::cos(9 * angle);
             const double radius = (0.075 + 0.29 * smoothstep(0, 0.5, v) + 0.05 * v) * fold;
             return Vec3{1.15 * radius * std::cos(angle), 1.40 - drop - 0.12 * smoothstep(0.2, 0.6, v),
                         -0.03 + radius * std::sin(angle) * 0.9 + knees};
           },
           2.2, 1.1, 36, 12, Wrap::kU}};
}

void add_legs(ShopParts& parts, const Placement& place) {
  for (const double side : {-1.0, 1.0}) {
    const Vec3 knee{0.13 * side, 0.72, 0.42}, foot{0.12 * side, 0.30, 0.56};
    parts[ShopPaint::kTrousers].add(cylinder({0.1 * side, 0.74, -0.05}, knee, 0.1, 0.075, true, 10), place);
    parts[ShopPaint::kTrousers].add(ellipsoid(knee, {0.08, 0.08, 0.08}, 10, 6), place);
    parts[ShopPaint::kTrousers].add(cylinder(knee, foot, 0.075, 0.055, true, 10), place);
    parts[ShopPaint::kBlack].add(cushion(foot + Vec3{0, -0.04, 0.07}, {0.05, 0.045, 0.14}), place);
  }
}

/// The barber's arm of one side, from the shoulder of `lean` to a hand that circles about `work`; the left
/// one holds a comb, the right one scissors.
void add_arm(ShopParts& arm, double side, const Rigid& stand, const std::function<Rigid(double)>& lean,
             Vec3 work) {
  const Vec3 toward = normalize(work - stand.translation);
  const auto shoulder = [=](double time) { return lean(time).apply({0.21 * side, 1.43, 0.02}); };
  const auto hand = [=](double time) {
    const double angle = 1.3 * kPi * time + side;
    return work + stand.apply(Vec3{0.11 * side, 0, 0}) - stand.translation +
           Vec3{0.03 * std::cos(angle), 0.05 + 0.05 * side + 0.03 * std::sin(angle), 0.05 - 0.12 * toward.z};
  };
  const auto elbow = [=](double time) {
    return lerp(shoulder(time), hand(time), 0.48) + stand.apply(Vec3{0.14 * side, -0.17, 0}) -
           stand.translation;
  };
  const auto limb = [&](ShopPaint paint, const auto& from, const auto& end, double ra, double rb) {
    arm[paint].add(cylinder({}, {0, length(end(0.0) - from(0.0)), 0}, ra, rb, true, 12),
                   {{}, between(from, end), 1});
  };
  limb(ShopPaint::kCoat, shoulder, elbow, 0.075, 0.06);
  limb(ShopPaint::kCoat, elbow, hand, 0.06, 0.042);
  const Motion held = on_dolly(rigid_motion([=](double time) { return translation(hand(time)); }));
  arm[ShopPaint::kSkin].add(ellipsoid({}, {0.045, 0.04, 0.05}, 12, 8), {{}, held, 1});
  for (const double blade : {-1.0, 1.0}) {  // scissors in one hand, a comb's two rows of teeth in the other
    const Motion snip = compose(held, rigid_motion([=](double time) {
                                  const double open = side > 0 ? 0.25 * (1 + std::cos(4 * kPi * time)) : 0.0;
                                  return rotation({0, 0, 1}, 0.4 * side + blade * open);
                                }));
    arm[ShopPaint::kChrome].add(box({-0.11 * side, 0.008 * blade, 0.03}, {0.10, 0.006, 0.006}),
                                {{}, snip, 2});
  }
}

}  // namespace

void add_chair(Barbershop& shop, const Chair& chair) {
  const Placement fixed{translation(chair.place), on_dolly(), 1};
  shop.furniture[ShopPaint::kChrome].add(
      lathe({{0.36, 0}, {0.36, 0.03}, {0.3, 0.06}, {0.1, 0.1}, {0.085, 0.4}}, 20), fixed);
  ShopParts& parts = shop.turning;
  const Placement place{{}, on_dolly(rigid_motion([chair](double time) { return chair.pose(time); })), 1};
  parts[ShopPaint::kChrome].add(cylinder({0, 0.38, 0}, {0, 0.54, 0}, 0.065, 0.13, true, 16), place);
  parts[ShopPaint::kLeather].add(cushion({0, 0.6, 0.02}, {0.3, 0.08, 0.3}), place);
  const Rigid back = translation({0, 0.98, -0.30}) * rotation({1, 0, 0}, -0.14);
  // Back with buttons pressed into it.
  parts[ShopPaint::kLeather].add(cushion({}, {0.29, 0.38, 0.07}), {back, place.motion, 1.2});
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      parts[ShopPaint::kBrass].add(ellipsoid({0.15 * i, 0.2 * j, 0.07}, {0.014, 0.014, 0.01}, 8, 4),
                                   {back, place.motion, 1});
    }
  }
  parts[ShopPaint::kLeather].add(cushion({0, 0.48, 0.0}, {0.11, 0.07, 0.05}), {back, place.motion, 1});
  for (const double side : {-1.0, 1.0}) {
    const double x = 0.36 * side;
    parts[ShopPaint::kChrome].add(tube(
                                      [x](double s) {
                                        return Vec3{x, 0.58 + 0.24 * std::sin(kPi * s), lerp(-0.3, 0.3, s)};
                                      },
                                      0.85, 0.025, {1, 0, 0}, 8, 12),
                                  place);
    parts[ShopPaint::kLeather].add(cushion({x, 0.85, 0.02}, {0.05, 0.035, 0.22}), place);
    parts[ShopPaint::kChrome].add(
        cylinder({0.2 * side, 0.52, 0.26}, {0.2 * side, 0.24, 0.5}, 0.02, 0.02, false, 8), place);
  }
  const Rigid rest = translation({0, 0.22, 0.58}) * rotation({1, 0, 0}, 0.35);
  parts[ShopPaint::kChrome].add(box({}, {0.24, 0.015, 0.13}), {rest, place.motion, 1});
  for (int k = -2; k <= 2; ++k) {
    parts[ShopPaint::kBlack].add(box({0, 0.02, 0.045 * k}, {0.22, 0.008, 0.012}), {rest, place.motion, 1});
  }
}

void add_customer(Barbershop& shop, const Chair& chair, ShopPaint hair, std::size_t strands,
                  std::uint64_t seed) {
  const auto pose = [chair](double time) { return chair.pose(time); };
  const Motion seated = on_dolly(rigid_motion(pose));
  add_head(shop.turning, kSeatedHead, seated);
  add_legs(shop.turning, {{}, seated, 1});
  shop.turning[ShopPaint::kWhite].add(torus({0, 1.40, -0.03}, {0, 1, 0.1}, 0.075, 0.022, 20, 6),
                                      {{}, seated, 1});
  // The cape billows as the chair turns: more at the hem than at the neck.
  const Motion billow = [](double time) -> PointMap {
    return [time](Vec3 p) {
      const double slack = smoothstep(1.35, 0.75, p.y);
      const double wave = std::sin(5 * p.x + 4 * p.z + 2 * kPi * time);
      return p + Vec3{0.02 * wave, 0.008 * wave, 0.025 * std::sin(6 * p.x - 2 * kPi * time)} * slack;
    };
  };
  shop.flowing[ShopPaint::kCape].add(make_cape(), {{}, on_dolly(compose(rigid_motion(pose), billow)), 1.2});
  add_hair(shop, kSeatedHead, pose, hair, strands, seed);
}

void add_barber(Barbershop& shop, Vec3 place, Vec3 work, std::size_t strands, std::uint64_t seed) {
  const Vec3 to = work - place;
  const double yaw = std::atan2(to.x, to.z);
  const Rigid stand = translation(place) * rotation({0, 1, 0}, yaw);
  const auto lean = [stand](double time) {
    return stand * rotation({1, 0, 0}, 0.10 + 0.03 * std::sin(kPi * time));
  };
  ShopParts& parts = shop.turning;
  const Placement body{{}, on_dolly(rigid_motion(lean)), 1};
  for (const double side : {-1.0, 1.0}) {
    const Vec3 foot{0.12 * side, 0.06, -0.02};
    parts[ShopPaint::kTrousers].add(cylinder(foot, {0.1 * side, 0.95, 0}, 0.06, 0.1, true, 12),
                                    {stand, on_dolly(), 1});
    parts[ShopPaint::kBlack].add(cushion(foot + Vec3{0, -0.01, 0.07}, {0.055, 0.05, 0.15}),
                                 {stand, on_dolly(), 1});
  }
  parts[ShopPaint::kCoat].add(smooth_lathe(
                                  [](double v) {
                                    return ProfilePoint{
                                        0.18 + 0.05 * std::cos(4.4 * v) - 0.14 * smoothstep(0.82, 1, v),
                                        0.68 + 0.82 * v};
                                  },
                                  0.2, 0.85, 20, 12),
                              body);
  parts[ShopPaint::kBlack].add(box({0, 1.42, 0.1}, {0.06, 0.02, 0.012}), body);  // bow tie
  const Vec3 head{0, 1.74, 0.02};
  add_head(parts, head, body.motion);
  parts[ShopPaint::kDarkHair].add(cushion(head + Vec3{0, -0.052, 0.118}, {0.05, 0.012, 0.014}),
                                  body);  // moustache
  for (const double side : {-1.0, 1.0}) add_arm(shop.flowing, side, stand, lean, work);
  add_hair(shop, head, lean, ShopPaint::kDarkHair, strands, seed);
}

}  // namespace stbvh::harness
