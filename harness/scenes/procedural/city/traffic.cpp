// Cars, people and signs of the static city: the tenth of it that moves.
#include "harness/scenes/procedural/city/city_pieces.h"
#include "harness/scenes/procedural/shared/spoked_wheel.h"

namespace stbvh::harness {
namespace {

/// Sine and cosine bent towards a square.
double squarish(double x) {
  return std::copysign(std::sqrt(std::abs(x)), x);
}

/// Closed hull along x: half-length, and half-width and heights that a shape function of x in [-1, 1] scales.
Patches hull(double half_length, double half_width, double bottom, double height,
             const std::function<double(double)>& shape) {
  return {{[=](double u, double v) {
             const double x = lerp(-1, 1, v);
             const double angle = 2 * kPi * u;
             const double end = std::pow(std::max(1 - std::pow(x, 8.0), 0.002), 0.25);
             const double top = height * shape(x) * end;
             return Vec3{half_length * x, bottom + 0.5 * top * (1 + squarish(std::sin(angle))),
                         half_width * end * squarish(std::cos(angle))};
           },
           4 * (half_width + 0.5 * height), 2 * half_length, 8, 5, Wrap::kU}};
}

/// Pose on a path of constant curvature after the share `f` of `travel`.
Rigid on_path(Vec3 start, double heading, double travel, double bend, double f) {
  const double turned = bend * f, s = travel * f;
  const double forward = std::abs(bend) < 1e-9 ? s : travel / bend * std::sin(turned);
  const double sideways = std::abs(bend) < 1e-9 ? 0 : travel / bend * (1 - std::cos(turned));
  const Rigid base = translation(start) * rotation({0, 1, 0}, heading);
  return base * translation({forward, 0, -sideways}) * rotation({0, 1, 0}, turned);
}

}  // namespace

Traffic::Traffic() {
  struct Color {
    const char* name;
    std::size_t steps;
    Vec3 color;
  };
  constexpr std::array<Color, kTrafficPaintCount> kColors{{{"red cars", 9, {0.60, 0.03, 0.03}},
                                                           {"blue cars", 9, {0.04, 0.12, 0.48}},
                                                           {"white cars", 9, {0.76, 0.76, 0.74}},
                                                           {"car windows", 9, {0.03, 0.04, 0.05}},
                                                           {"tyres", 9, {0.02, 0.02, 0.02}},
                                                           {"hubs", 9, {0.55, 0.56, 0.58}},
                                                           {"skin", 17, {0.55, 0.33, 0.22}},
                                                           {"orange shirts", 17, {0.75, 0.28, 0.05}},
                                                           {"teal shirts", 17, {0.04, 0.33, 0.36}},
                                                           {"trousers", 17, {0.06, 0.07, 0.13}},
                                                           {"signs", 13, {0.80, 0.62, 0.06}},
                                                           {"sign bands", 13, {0.55, 0.05, 0.05}}}};
  for (const Color& color : kColors) parts_.push_back({color.name, color.steps, color.color, {}, {}});
}

void add_car(Traffic& traffic, Vec3 start, double heading, double travel, double bend, TrafficPaint paint) {
  const auto pose = [=](double time) { return on_path(start, heading, travel, bend, time); };
  const Placement body{{}, rigid_motion(pose), 1};
  traffic[paint].add(hull(2.1, 0.85, 0.28, 0.62, [](double x) { return 0.86 + 0.14 * std::cos(2.4 * x); }),
                     body);
  const auto cabin = [](double x) { return 1 - 0.12 * x * x; };
  const auto shifted = [&](Patches patches, Vec3 by, double detail) {
    Part part;
    part.add(patches, {translation(by), {}, detail});
    return part.patches;
  };
  traffic[TrafficPaint::kCarGlass].add(shifted(hull(1.15, 0.74, 0.84, 0.42, cabin), {-0.25, 0, 0}, 1), body);
  traffic[paint].add(shifted(hull(0.98, 0.7, 1.18, 0.16, cabin), {-0.28, 0, 0}, 1), body);
  for (const double z : {-0.6, 0.6}) {
    traffic[TrafficPaint::kHub].add(ellipsoid({2.02, 0.62, z}, {0.1, 0.1, 0.14}, 5, 3), body);
  }
  constexpr double kRadius = 0.33;
  for (const double x : {-1.3, 1.3}) {
    for (const double side : {-1.0, 1.0}) {
      const Rigid hub = translation({x, kRadius, 0.8 * side});
      const Placement wheel{{},
                            rigid_motion([=](double time) {
                              return pose(time) * hub * rotation({0, 0, 1}, -travel / kRadius * time);
                            }),
                            1};
      traffic[TrafficPaint::kTyre].add(torus({}, {0, 0, 1}, 0.25, 0.085, 8, 3), wheel);
      for (int i = 0; i < 5; ++i) {
        const double angle = 2 * kPi * i / 5;
        traffic[TrafficPaint::kHub].add(
            quad({0.03 * std::cos(angle + 1.5), 0.03 * std::sin(angle + 1.5), 0.06 * side},
                 {0.24 * std::cos(angle + 0.12), 0.24 * std::sin(angle + 0.12), 0.06 * side},
                 {0.24 * std::cos(angle - 0.12), 0.24 * std::sin(angle - 0.12), 0.06 * side},
                 {0.03 * std::cos(angle - 1.5), 0.03 * std::sin(angle - 1.5), 0.06 * side}),
            wheel);
      }
    }
  }
}

void add_walker(Traffic& traffic, Vec3 start, double heading, double travel, TrafficPaint shirt,
                Pcg32& random) {
  const double phase = random.uniform(0, 2 * kPi);
  const double size = random.uniform(0.92, 1.06);
  const auto stride = [=](double time) { return phase + 4.2 * travel * time; };
  const auto pose = [=](double time) {
    const double bob = 0.03 * std::cos(2 * stride(time));
    return on_path(start, heading, travel, 0, time) * translation({0, bob, 0}) *
           rotation({0, 1, 0}, 0.1 * std::sin(stride(time)));
  };
  const auto limb = [=](Vec3 joint, double swing, double lag) {
    return Placement{
        {},
        rigid_motion([=](double time) {
          return pose(time) * rotation_about(joint, {0, 0, 1}, swing * std::sin(stride(time) + lag));
        }),
        1};
  };
  const auto bone = [size](Vec3 a, Vec3 b, double ra, double rb) {
    return cylinder(a * size, b * size, ra, rb, true, 6);
  };
  const Placement trunk{{}, rigid_motion(pose), 1};
  traffic[shirt].add(ellipsoid({0, 1.18 * size, 0}, {0.15, 0.34, 0.21}, 8, 5), trunk);
  traffic[TrafficPaint::kSkin].add(ellipsoid({0.02, 1.66 * size, 0}, {0.11, 0.14, 0.1}, 8, 5), trunk);
  traffic[TrafficPaint::kTrousers].add(ellipsoid({-0.01, 1.74 * size, 0}, {0.125, 0.09, 0.115}, 8, 4), trunk);
  for (const double side : {-1.0, 1.0}) {
    const double lag = side > 0 ? 0 : kPi;
    const Vec3 hip{0, 0.92, 0.1 * side}, shoulder{0, 1.42, 0.23 * side};
    traffic[TrafficPaint::kTrousers].add(bone(hip, {0, 0.08, 0.1 * side}, 0.1, 0.055),
                                         limb(hip * size, 0.5, lag));
    traffic[shirt].add(bone(shoulder, {0.02, 1.12, 0.26 * side}, 0.065, 0.05),
                       limb(shoulder * size, 0.5, lag + kPi));
    traffic[TrafficPaint::kSkin].add(bone({0.02, 1.12, 0.26 * side}, {0.06, 0.84, 0.27 * side}, 0.045, 0.035),
                                     limb(shoulder * size, 0.5, lag + kPi));
  }
}

void add_turning_sign(Traffic& traffic, Vec3 foot, double height, double radians) {
  const Motion turning = rigid_motion([=](double time) {
    return rotation_about(foot, {0, 1, 0}, radians * time);
  });
  const Vec3 top = foot + Vec3{0, height, 0};
  const Placement place{{}, turning, 1};
  traffic[TrafficPaint::kSignBand].add(cylinder(foot, top, 0.06, 0.05, false, 6), place);
  traffic[TrafficPaint::kSign].add(box(top, {0.62, 0.42, 0.07}), place);
  traffic[TrafficPaint::kSignBand].add(box(top, {0.5, 0.12, 0.09}), place);
  traffic[TrafficPaint::kSignBand].add(ellipsoid(top + Vec3{0, 0.5, 0}, {0.1, 0.1, 0.1}, 6, 4), place);
}

}  // namespace stbvh::harness
