// Wheels of all kinds turning fast on their stands, which a turntable carries round: 317k triangles with 9
// steps.
#include <array>

#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/shared/spoked_wheel.h"

namespace stbvh::harness {
namespace {

enum class Finish { kWood, kIron, kSteel, kRubber, kRed, kBlue, kBrass, kFloorLight, kFloorDark, kStand };
constexpr std::size_t kFinishCount = 10;

constexpr double kTableTurn = 2.5 * kPi / 180;  // of the turntable over the shutter

struct Workshop {
  std::vector<Part> parts;
  Part& operator[](Finish finish) { return parts[static_cast<std::size_t>(finish)]; }
};

Workshop make_workshop() {
  struct Color {
    const char* name;
    Vec3 color;
  };
  constexpr std::array<Color, kFinishCount> kColors{{{"wood", {0.36, 0.17, 0.06}},
                                                     {"iron", {0.10, 0.10, 0.11}},
                                                     {"steel", {0.34, 0.36, 0.39}},
                                                     {"rubber", {0.03, 0.03, 0.03}},
                                                     {"red paint", {0.60, 0.04, 0.03}},
                                                     {"blue paint", {0.05, 0.15, 0.45}},
                                                     {"brass", {0.80, 0.52, 0.14}},
                                                     {"light floor", {0.62, 0.58, 0.50}},
                                                     {"dark floor", {0.40, 0.36, 0.31}},
                                                     {"stands", {0.16, 0.22, 0.18}}}};
  Workshop shop;
  for (const Color& color : kColors) shop.parts.push_back({color.name, 9, color.color, {}, {}});
  return shop;
}

Rigid table_pose(double time) {
  return rotation({0, 1, 0}, kTableTurn * (time - 0.5));
}

/// A wheel's place: its axle's height is its radius plus a hand's breadth, it faces `yaw` from +z.
struct Stand {
  double x, z, yaw;
  double radius;
  double turn_degrees;  // over the shutter
  double phase = 0;
  double lift = 0.25;

  Rigid pose() const { return translation({x, radius + lift, z}) * rotation({0, 1, 0}, yaw); }
  Placement turning(double detail) const {
    const Rigid at = pose();
    return {at * rotation({0, 0, 1}, phase),
            rigid_motion([at, back = inverse(at), angle = turn_degrees * kPi / 180](double time) {
              return table_pose(time) * at * rotation({0, 0, 1}, angle * time) * back;
            }),
            detail};
  }
  Placement standing(double detail) const { return {pose(), rigid_motion(table_pose), detail}; }
};

/// A post on a foot behind the wheel, and the axle.
void add_stand(Workshop& shop, const Stand& stand) {
  const double height = stand.radius + stand.lift;
  const double behind = -0.32;
  Part& part = shop[Finish::kStand];
  part.add(box({0, -height + 0.04, behind}, {0.35 * stand.radius, 0.04, 0.22}), stand.standing(0.6));
  for (const double side : {-1.0, 1.0}) {
    part.add(cylinder({side * 0.3 * stand.radius, -height, behind}, {0, 0, behind}, 0.05, 0.05, true, 5),
             stand.standing(1));
  }
  shop[Finish::kSteel].add(cylinder({0, 0, behind - 0.08}, {0, 0, 0.1}, 0.04, 0.04, true, 5),
                           stand.standing(1));
}

void add_cart_wheel(Workshop& shop, const Stand& stand) {
  const double r = stand.radius;
  const WheelPatches wheel = make_spoked_wheel({0.97 * r, 0.11 * r, 0.11, 12, 0.045 * r, 0.14 * r, 0.34, 0});
  shop[Finish::kWood].add(join({wheel.rim, wheel.spokes, wheel.hub}), stand.turning(1.2));
  shop[Finish::kIron].add(flat_ring(0.97 * r, r, 0.13, 14), stand.turning(1.2));
  shop[Finish::kIron].add(torus({0, 0, 0.17}, {0, 0, 1}, 0.14 * r, 0.02, 10, 3), stand.turning(1.5));
  add_stand(shop, stand);
}

void add_bicycle_wheel(Workshop& shop, const Stand& stand) {
  const double r = stand.radius;
  shop[Finish::kRubber].add(torus({}, {0, 0, 1}, 0.96 * r, 0.04 * r, 16, 5), stand.turning(1.2));
  shop[Finish::kSteel].add(flat_ring(0.89 * r, 0.925 * r, 0.05, 14), stand.turning(1.5));
  constexpr int kSpokes = 36;
  for (int i = 0; i < kSpokes; ++i) {  // they leave the hub's flanges at a tangent, to either side in turn
    const double out = 2 * kPi * i / kSpokes;
    const double from = out + (i % 4 < 2 ? 1.25 : -1.25);
    const double z = i % 2 == 0 ? 0.1 : -0.1;
    shop[Finish::kSteel].add(
        cylinder({0.055 * r * std::cos(from), 0.055 * r * std::sin(from), z},
                 {0.9 * r * std::cos(out), 0.9 * r * std::sin(out), 0}, 0.009, 0.009, false, 3),
        stand.turning(1));
  }
  shop[Finish::kSteel].add(cylinder({0, 0, -0.14}, {0, 0, 0.14}, 0.035 * r, 0.035 * r, true, 8),
                           stand.turning(1.5));
  shop[Finish::kSteel].add(flat_ring(0.03 * r, 0.07 * r, 0.22, 10), stand.turning(1.5));
  shop[Finish::kRed].add(cylinder({0.88 * r, -0.03, 0}, {0.88 * r, 0.03, 0}, 0.05, 0.05, true, 5),
                         stand.turning(2));  // reflector
  add_stand(shop, stand);
}

void add_engine_wheel(Workshop& shop, const Stand& stand) {
  const double r = stand.radius;
  const WheelPatches wheel = make_spoked_wheel({r, 0.1 * r, 0.14, 15, 0.03 * r, 0.18 * r, 0.26, 0.04 * r});
  shop[Finish::kSteel].add(wheel.rim, stand.turning(1.2));
  shop[Finish::kRed].add(join({wheel.spokes, wheel.hub}), stand.turning(1.2));
  for (const double z : {-0.06, 0.06}) {  // counterweight
    const auto crescent = [=](double u, double v) {
      const double angle = kPi * (0.7 + 0.6 * u);
      const double inner = 0.86 * r - 0.26 * r * std::sin(kPi * u);
      const double radius = lerp(inner, 0.91 * r, v);
      return Vec3{radius * std::cos(angle), radius * std::sin(angle), z};
    };
    shop[Finish::kRed].add(sheet(crescent, 1.7 * r, 0.25 * r, 8, 2), stand.turning(1.2));
  }
  shop[Finish::kBrass].add(cylinder({0.42 * r, 0, 0.05}, {0.42 * r, 0, 0.26}, 0.07 * r, 0.07 * r, true, 8),
                           stand.turning(1.5));
  add_stand(shop, stand);
}

void add_gear(Workshop& shop, Finish finish, const Stand& stand, int teeth) {
  const double r = stand.radius;
  Part& part = shop[finish];
  part.add(flat_ring(0.78 * r, 0.92 * r, 0.16, 14), stand.turning(1.2));
  for (int i = 0; i < teeth; ++i) {
    Placement place = stand.turning(1.2);
    place.pose = place.pose * rotation({0, 0, 1}, 2 * kPi * i / teeth);
    part.add(box({0.97 * r, 0, 0}, {0.07 * r, 0.75 * r / teeth, 0.08}), place);
  }
  for (int i = 0; i < 5; ++i) {
    Placement place = stand.turning(1.2);
    place.pose = place.pose * rotation({0, 0, 1}, 2 * kPi * i / 5);
    part.add(box({0.48 * r, 0, 0}, {0.32 * r, 0.05 * r, 0.05}), place);
  }
  part.add(cylinder({0, 0, -0.12}, {0, 0, 0.16}, 0.18 * r, 0.18 * r, true, 14), stand.turning(1.2));
  add_stand(shop, stand);
}

/// The turntable: a chequered disc with a rim.
void add_table(Workshop& shop) {
  constexpr int kSectors = 28, kRings = 6;
  constexpr double kRadius = 5.6;
  const Placement place{{}, rigid_motion(table_pose), 0.35};
  for (int i = 0; i < kSectors; ++i) {
    for (int j = 0; j < kRings; ++j) {
      const auto tile = [=](double u, double v) {
        const double angle = -2 * kPi * (i + u) / kSectors;
        const double radius = kRadius * (j + 0.02 + v * 0.98) / kRings;
        return Vec3{radius * std::cos(angle), 0, radius * std::sin(angle)};
      };
      const double width = 2 * kPi * kRadius * (j + 1) / kRings / kSectors;
      shop[(i + j) % 2 == 0 ? Finish::kFloorLight : Finish::kFloorDark].add(
          sheet(tile, width, kRadius / kRings), place);
    }
  }
  shop[Finish::kBlue].add(
      lathe({{kRadius + 0.01, 0}, {kRadius + 0.15, 0}, {kRadius + 0.15, -0.3}, {kRadius + 0.01, -0.3}}, 48),
      place);
}

}  // namespace

Scene make_wheels(double scale, std::uint64_t seed) {
  Workshop shop = make_workshop();
  Pcg32 random(seed, 21);
  const auto stand = [&](double x, double z, double yaw, double radius, double degrees) {
    return Stand{x, z, yaw, radius, degrees, random.uniform(0, 2 * kPi)};
  };
  add_table(shop);
  add_cart_wheel(shop, stand(-2.9, -1.6, 0.30, 1.55, -24));
  add_engine_wheel(shop, stand(0.3, -2.5, 0.0, 1.75, 64));
  add_cart_wheel(shop, stand(3.4, -1.5, -0.35, 1.45, 75));
  add_bicycle_wheel(shop, stand(-1.5, 0.7, 0.2, 0.95, -110));
  add_bicycle_wheel(shop, stand(2.0, 0.5, -0.25, 1.0, 16));
  add_engine_wheel(shop, stand(-3.6, 1.3, 0.5, 0.7, -150));
  add_cart_wheel(shop, stand(4.0, 1.2, -0.5, 0.75, -40));
  // Two gears that mesh.
  Stand large{-0.05, 2.2, 0.0, 0.62, 48, 0.0, 0.25};
  Stand small{0.0, 2.2, 0.0, 0.31, -96, kPi / 12, 0.56};
  small.x = large.x + 0.93 * (large.radius + small.radius) + 0.03;
  add_gear(shop, Finish::kBrass, large, 24);
  add_gear(shop, Finish::kSteel, small, 12);
  add_bicycle_wheel(shop, stand(-1.9, 3.0, 0.35, 0.45, 35));
  add_engine_wheel(shop, stand(2.2, 2.8, -0.35, 0.5, 30));

  Scene scene;
  scene.name = "wheels";
  scene.meshes = tessellate(shop.parts, scaled_count(317e3, scale));
  scene.camera = {{0.6f, 3.4f, 10.5f}, {0.1f, 1.35f, 0.0f}, {0, 1, 0}, 38.0f};
  return scene;
}

}  // namespace stbvh::harness
