/// A llama in a walk, its wool of several lengths and colours.
#include <algorithm>

#include "harness/scenes/procedural/llama/fur.h"
#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/scene_plan.h"

namespace stbvh::harness {
namespace {

enum LlamaJoint : std::size_t {
  kHips,
  kTrunk,
  kBreast,
  kNeckBase,
  kNeckTop,
  kSkull,
  kEarL,
  kEarR,
  kTail,
  kForeLegL,
  kForeKneeL,
  kForeFootL,
  kForeLegR,
  kForeKneeR,
  kForeFootR,
  kHindLegL,
  kHindKneeL,
  kHindFootL,
  kHindLegR,
  kHindKneeR,
  kHindFootR
};

constexpr double kFootHeight = 0.1;  ///< of the foot joints above the ground

constexpr Vec3f kHide{0.5f, 0.38f, 0.27f};
constexpr Vec3f kHoof{0.06f, 0.05f, 0.045f};
constexpr Vec3f kGrass{0.2f, 0.3f, 0.1f};

Skeleton make_skeleton() {
  Skeleton s;
  s.add(kNoJoint, {0, 1.02, -0.42});
  s.add(kHips, {0, 1.04, -0.05});
  s.add(kTrunk, {0, 1.02, 0.3});
  s.add(kBreast, {0, 1.12, 0.46});
  s.add(kNeckBase, {0, 1.42, 0.55});
  s.add(kNeckTop, {0, 1.7, 0.6});
  s.add(kSkull, {0.055, 1.8, 0.57});
  s.add(kSkull, {-0.055, 1.8, 0.57});
  s.add(kHips, {0, 1.1, -0.64});
  for (const double x : {0.14, -0.14}) {
    const std::size_t leg = s.add(kBreast, {x, 0.9, 0.33});
    s.add(s.add(leg, {x, 0.47, 0.35}), {x, kFootHeight, 0.34});
  }
  for (const double x : {0.145, -0.145}) {
    const std::size_t leg = s.add(kHips, {x, 0.9, -0.42});
    s.add(s.add(leg, {x, 0.5, -0.55}), {x, kFootHeight, -0.52});
  }
  return s;
}

void add_leg(ImplicitBody& body, const Skeleton& s, std::size_t leg, double thigh) {
  const Vec3 top = s.rest[leg], knee = s.rest[leg + 1], foot = s.rest[leg + 2];
  body.add({top, knee, thigh, 0.055, leg, 0.06, {0.8, 1, 1}});
  body.add({knee, foot, 0.05, 0.038, leg + 1, 0.03});
  body.add({foot, foot + Vec3{0, -0.055, 0.03}, 0.042, 0.042, leg + 2, 0.02});
  for (const double x : {-0.022, 0.022}) {
    body.add({foot + Vec3{x, -0.06, 0.03}, foot + Vec3{1.2 * x, -0.077, 0.085}, 0.033, 0.02, leg + 2, 0.006});
  }
}

ImplicitBody make_body(const Skeleton& s) {
  ImplicitBody body;
  body.add({{0, 1.0, -0.4}, {0, 1.02, -0.05}, 0.25, 0.27, kHips, 0.08, {0.85, 1, 1}});
  body.add({{0, 1.0, -0.1}, {0, 1.0, 0.25}, 0.27, 0.26, kTrunk, 0.08, {0.85, 1, 1}});
  body.add({{0, 0.99, 0.28}, {0, 1.05, 0.36}, 0.25, 0.2, kBreast, 0.08, {0.8, 1, 1}});
  body.add(
      {s.rest[kNeckBase] - Vec3{0, 0.05, 0.03}, s.rest[kNeckTop], 0.17, 0.11, kNeckBase, 0.08, {0.85, 1, 1}});
  body.add({s.rest[kNeckTop], s.rest[kSkull], 0.11, 0.092, kNeckTop, 0.05, {0.9, 1, 1}});
  body.add({{0, 1.72, 0.6}, {0, 1.73, 0.66}, 0.1, 0.092, kSkull, 0.04, {0.85, 1, 1}});
  body.add({{0, 1.7, 0.68}, {0, 1.64, 0.85}, 0.07, 0.05, kSkull, 0.04, {0.85, 1, 1}});
  body.add({{0, 1.645, 0.85}, {0, 1.632, 0.866}, 0.05, 0.044, kSkull, 0.02});
  body.add({{0, 1.612, 0.85}, {0, 1.608, 0.86}, 0.034, 0.03, kSkull, 0.006});
  for (const double side : {1.0, -1.0}) {
    const std::size_t ear = side > 0 ? kEarL : kEarR;
    const Vec3 base{side * 0.055, 1.79, 0.57}, bend{side * 0.085, 1.9, 0.57}, tip{side * 0.062, 1.98, 0.6};
    body.add({base, bend, 0.03, 0.033, ear, 0.02, {1, 1, 0.55}});
    body.add({bend, tip, 0.033, 0.008, ear, 0.015, {1, 1, 0.55}});
    body.add({{side * 0.05, 1.745, 0.68}, {side * 0.055, 1.745, 0.67}, 0.03, 0.03, kSkull, 0.012});  // brow
    body.add({{side * 0.022, 1.662, 0.905},
              {side * 0.024, 1.664, 0.9},
              0.011,
              0.011,
              kSkull,
              0.008,
              {1, 1, 1},
              true});
  }
  body.add({s.rest[kTail], s.rest[kTail] + Vec3{0, -0.2, -0.1}, 0.05, 0.035, kTail, 0.04});
  for (const std::size_t leg : {kForeLegL, kForeLegR}) add_leg(body, s, leg, 0.12);
  for (const std::size_t leg : {kHindLegL, kHindLegR}) add_leg(body, s, leg, 0.17);
  return body;
}

/// A walk through about a twelfth of its cycle, the head turning towards the camera.
Pose walk(const Skeleton& s, double time) {
  constexpr Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
  Pose pose{std::vector<Quaternion>(s.rest.size()), {}};
  const double cycle = 0.6 + 0.55 * time;
  const auto step = [&](std::size_t leg, double offset, double bend) {
    const double swing = std::sin(cycle + offset);
    const double lift = std::fmax(0.0, std::cos(cycle + offset));
    pose.turns[leg] = axis_angle(kX, -0.38 * swing);
    pose.turns[leg + 1] = axis_angle(kX, bend * lift);
    pose.turns[leg + 2] = axis_angle(kX, 0.3 * lift + 0.25 * swing);
  };
  step(kForeLegL, 0.0, 0.9);
  step(kForeLegR, kPi, 0.9);
  step(kHindLegL, 0.5 * kPi, 0.7);
  step(kHindLegR, 1.5 * kPi, 0.7);
  pose.turns[kTrunk] = axis_angle(kZ, 0.03 * std::sin(cycle));
  pose.turns[kNeckBase] =
      axis_angle(kX, 0.1 + 0.09 * std::sin(1.5 * cycle)) * axis_angle(kY, 0.15 + 0.03 * time);
  pose.turns[kNeckTop] = axis_angle(kY, 0.2 + 0.06 * time) * axis_angle(kX, -0.05);
  pose.turns[kSkull] = axis_angle(kY, 0.25 + 0.08 * time) * axis_angle(kX, 0.1 - 0.1 * std::sin(2 * cycle));
  pose.turns[kEarL] = axis_angle(kZ, -0.1 - 0.15 * time);
  pose.turns[kEarR] = axis_angle(kZ, 0.12 + 0.1 * std::sin(3 * cycle));
  pose.turns[kTail] = axis_angle(kZ, 0.5 * std::sin(2.2 * cycle));
  pose.root.translation.z = 0.1 * (time - 0.5);
  const std::vector<Rigid> moved = skin_transforms(s, pose);
  double lowest = 1e9;
  for (const std::size_t foot : {kForeFootL, kForeFootR, kHindFootL, kHindFootR})
    lowest = std::fmin(lowest, moved[foot].apply(s.rest[foot]).y - kFootHeight);
  pose.root.translation.y = -lowest;
  return pose;
}

bool is_hoof(Vec3 p) {
  return p.y < 0.045;
}
bool is_muzzle(Vec3 p) {
  return p.z > 0.875 && p.y < 1.69 && p.y > 1.5;
}
bool is_face(Vec3 p) {
  return p.y > 1.55 && p.z > 0.69;
}
bool is_ear(Vec3 p) {
  return p.y > 1.83;
}
bool is_shank(Vec3 p) {
  return p.y < 0.5;
}

/// Brown patches on cream wool, darker legs and head.
std::size_t wool_colour(Vec3 p) {
  const double patch =
      std::sin(5.1 * p.z + 1.3) + std::sin(6.3 * p.y + 2.1 * p.x) + 0.6 * std::sin(11 * p.x + 7 * p.z);
  const double grain = 0.35 * std::sin(190 * p.x + 170 * p.y) * std::sin(210 * p.z);
  if (is_shank(p) || is_face(p)) return patch + grain > 1.2 ? 0 : 1;
  if (patch + grain > 0.85 && p.y < 1.3) return 2;
  return patch + grain < -0.9 ? 1 : 0;
}

/// Long, hanging wool on trunk, neck, thighs and tail.
FurAt wool_at(Vec3 p, Vec3 normal) {
  FurAt fur;
  fur.combed = normalize(Vec3{0.9 * normal.x, -1, -0.35});
  fur.lift = 0.55;
  fur.colour = wool_colour(p);
  if (is_face(p) || is_ear(p) || is_shank(p)) return fur;
  const bool neck = p.y > 1.25;
  fur.length = neck ? lerp(0.1, 0.06, smoothstep(1.3, 1.75, p.y)) : 0.13;
  fur.length = lerp(0.035, fur.length, smoothstep(0.5, 0.72, p.y));
  if (p.z < -0.64) fur.length = 0.16;
  return fur;
}

/// The short coat of face, ears and shanks.
FurAt short_coat_at(Vec3 p, Vec3) {
  FurAt fur;
  fur.combed = is_face(p) ? Vec3{0, -0.3, -1} : is_ear(p) ? Vec3{0, 1, 0} : Vec3{0, -1, -0.2};
  fur.lift = 0.3;
  fur.colour = wool_colour(p);
  if (is_hoof(p) || is_muzzle(p) || !(is_face(p) || is_ear(p) || is_shank(p))) return fur;
  fur.length = is_face(p) ? 0.014 : is_ear(p) ? 0.02 : 0.022;
  fur.density = is_shank(p) ? 0.6 : 1.0;
  return fur;
}

/// Strands get thinner as there are more of them, so that the skin stays covered.
double strand_radius(std::size_t strands, double radius_of_ten_thousand) {
  return radius_of_ten_thousand * std::sqrt(1e4 / static_cast<double>(std::max<std::size_t>(strands, 500)));
}

Shape make_eyes() {
  Shape eyes;
  for (const double side : {-1.0, 1.0}) {
    Shape eye = make_ellipsoid({0.016, 0.02, 0.024}, 16, 12);
    eye.transform(translation({side * 0.073, 1.735, 0.69}));
    eyes.append(eye);
  }
  return eyes;
}

/// Low hills and a fence behind the animal.
void add_meadow(Scene& scene) {
  const Shape ground = make_grid(24, 24, [](double u, double v) {
    const double x = 60 * u - 30, z = 30 - 60 * v;
    const double far = smoothstep(4, 26, std::hypot(x, z));
    return Vec3{x, far * (0.7 + 0.9 * std::sin(0.35 * x + 0.5) * std::sin(0.27 * z)), z};
  });
  add_mesh(scene, make_static_mesh("meadow", ground, kGrass));
  Shape fence;
  for (int i = -5; i <= 5; ++i) fence.append(make_box({-2.2, 0.55, 1.9 * i}, {0.06, 0.6, 0.06}));
  for (const double y : {0.45, 0.95}) fence.append(make_box({-2.12, y, 0}, {0.025, 0.06, 10}));
  add_mesh(scene, make_static_mesh("fence", fence, {0.3f, 0.22f, 0.15f}));
}

}  // namespace

Scene make_llama(double scale, std::uint64_t seed) {
  Scene scene;
  scene.name = "llama";
  planned_triangles(scene.name, 9, scale);  // refuses a scale that cannot be had
  const LlamaPlan plan = plan_llama(scale);
  const Skeleton skeleton = make_skeleton();
  const PoseAt pose = [&](double time) { return walk(skeleton, time); };
  const auto nine = transforms_over_steps(skeleton, pose, 9);

  const SkinnedShape body = SkinnedShape::from(make_body(skeleton), skeleton, plan.body_triangles);
  const auto horn = [](Vec3 p) { return is_hoof(p) || is_muzzle(p); };
  add_mesh(scene, skin("hide", body.select([&](Vec3 p) { return !horn(p); }), nine, kHide));
  add_mesh(scene, skin("hooves and nose", body.select(horn), nine, kHoof));
  add_mesh(scene, skin("eyes", SkinnedShape::rigid(make_eyes(), kSkull), nine, {0.01f, 0.01f, 0.012f}));

  FurSettings coat;
  coat.strands = plan.short_strands;
  coat.segments = kShortStrandSegments;
  coat.root_radius = strand_radius(coat.strands, 0.0013);
  coat.colours = {{0.75f, 0.65f, 0.5f}, {0.52f, 0.37f, 0.22f}, {0.28f, 0.14f, 0.06f}};
  coat.seed = seed;
  for (Mesh& mesh : grow_fur("short coat", body, coat, short_coat_at, nine)) add_mesh(scene, std::move(mesh));
  FurSettings wool = coat;
  wool.strands = plan.long_strands;
  wool.segments = kLongStrandSegments;
  wool.root_radius = strand_radius(wool.strands, 0.003);
  wool.sway = 0.06;
  wool.seed = seed + 1;
  for (Mesh& mesh : grow_fur("wool", body, wool, wool_at, transforms_over_steps(skeleton, pose, 3)))
    add_mesh(scene, std::move(mesh));
  add_meadow(scene);
  scene.camera = {{3.3f, 1.55f, 2.5f}, {0.0f, 1.0f, 0.12f}, {0, 1, 0}, 34.0f};
  return scene;
}

}  // namespace stbvh::harness
