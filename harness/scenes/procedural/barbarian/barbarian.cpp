/// A muscular figure with a sword, beard and kilt: swinging it (barbarian), or turning half a turn.
#include <algorithm>

#include "harness/scenes/procedural/barbarian/body_cage.h"
#include "harness/scenes/procedural/barbarian/trailing.h"
#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "harness/scenes/procedural/shared/human.h"

namespace stbvh::harness {
namespace {

constexpr Vec3f kSkin{0.62f, 0.36f, 0.23f};
constexpr Vec3f kLeather{0.16f, 0.075f, 0.03f};
constexpr Vec3f kPelt{0.33f, 0.2f, 0.1f};
constexpr Vec3f kHair{0.42f, 0.13f, 0.03f};
constexpr Vec3f kSteel{0.55f, 0.6f, 0.68f};
constexpr Vec3f kGround{0.3f, 0.33f, 0.24f};

constexpr std::size_t kTurningSteps = 9;

/// Shares of the triangles; the kilt takes what is left.
constexpr double kBodyShare = 0.58;
constexpr double kHairShare = 0.2;
constexpr double kSwordShare = 0.08;

/// Direction along which the sword sticks out of the right fist at rest.
Vec3 sword_axis(const Skeleton& s) {
  return normalize(Vec3{0, 0, 1} * 0.8 + rest_direction(s, kShoulderR, kWristR) * 0.6);
}

/// Legs astride, arms out; what both scenes start from.
Pose fighting_stance(double crouch) {
  constexpr Vec3 kX{1, 0, 0}, kZ{0, 0, 1};
  Pose pose = standing_pose();
  pose.turns[kHipL] = axis_angle(kX, -0.45 - crouch) * axis_angle(kZ, 0.24);
  pose.turns[kHipR] = axis_angle(kX, 0.22 - 0.4 * crouch) * axis_angle(kZ, -0.26);
  pose.turns[kKneeL] = axis_angle(kX, 0.5 + 1.4 * crouch);
  pose.turns[kKneeR] = axis_angle(kX, 0.25 + 0.8 * crouch);
  pose.turns[kAnkleL] = axis_angle(kX, -0.05 - 0.4 * crouch) * axis_angle(kZ, -0.2);
  pose.turns[kAnkleR] = axis_angle(kX, -0.3 - 0.3 * crouch) * axis_angle(kZ, 0.2);
  return pose;
}

void set_arms(const Skeleton& s, Pose& pose, Vec3 sword_arm, Vec3 sword, double elbow, Vec3 free_arm) {
  const Vec3 right = rest_direction(s, kShoulderR, kWristR), left = rest_direction(s, kShoulderL, kWristL);
  pose.turns[kShoulderR] = align(right, {0, 0, 1}, sword_arm, sword);
  pose.turns[kElbowR] = axis_angle(cross(right, {0, 0, 1}), elbow);
  pose.turns[kShoulderL] = align(left, {0, 0, 1}, free_arm, {0.2, 1, 0.6});
  pose.turns[kElbowL] = axis_angle(cross(left, {0, 0, 1}), 0.9);
}

/// A blow from behind the head across the body, the trunk twisting with it.
Pose swinging_pose(const Skeleton& s, double time) {
  const double f = smoothstep(0.03, 0.97, time);
  Pose pose = fighting_stance(0.05 + 0.3 * f);
  const double twist = lerp(-0.55, 0.6, f);
  pose.turns[kPelvis] = axis_angle({0, 1, 0}, 0.35 * twist);
  pose.turns[kSpine] = axis_angle({0, 1, 0}, 0.5 * twist) * axis_angle({1, 0, 0}, lerp(-0.12, 0.22, f));
  pose.turns[kChest] = axis_angle({0, 1, 0}, 0.6 * twist) * axis_angle({1, 0, 0}, lerp(-0.1, 0.2, f));
  pose.turns[kHead] = axis_angle({0, 1, 0}, -1.0 * twist);
  const double angle = lerp(-0.6, 1.45, f);  // of the arm, from straight up towards the front
  const Vec3 arm{-0.55 + 0.45 * f, std::cos(angle), std::sin(angle)};
  const double lead = angle + lerp(-1.1, 0.75, f);  // of the blade: behind the hand at first, then ahead
  const Vec3 blade{-0.1 + 0.35 * f, std::cos(lead), std::sin(lead)};
  set_arms(s, pose, arm, blade, lerp(0.9, 0.15, f), {0.8, lerp(0.1, -0.45, f), lerp(0.5, -0.35, f)});
  stand_on_ground(s, pose);
  return pose;
}

/// Sword held high, the whole figure turning about itself by half a turn.
Pose turning_pose(const Skeleton& s, double time) {
  Pose pose = fighting_stance(0.05);
  pose.turns[kHead] = axis_angle({0, 1, 0}, 0.25);
  set_arms(s, pose, {-0.75, 0.7, 0.1}, {0.2, 0.8, 0.5}, 0.5, {0.85, -0.25, 0.35});
  stand_on_ground(s, pose);
  pose.root = rotation({0, 1, 0}, kPi * (time - 0.5)) * pose.root;
  return pose;
}

SkinnedShape make_sword(const Skeleton& s, std::size_t triangles) {
  const Vec3 arm = rest_direction(s, kShoulderR, kWristR);
  const Vec3 along = sword_axis(s);
  const Vec3 grip = s.rest[kWristR] + arm * 0.085 + Vec3{0.026, -0.02, 0};
  const Vec3 across = normalize(cross(along, cross(arm, along)));
  const auto at = [&](double distance) { return grip + along * distance; };
  const std::size_t around = detail(12, 4, triangles, 8000);
  const std::size_t shaft = detail(6, 1, triangles, 8000);
  Shape sword = make_capsule(at(-0.14), at(0.1), 0.017, 0.017, around, shaft);
  sword.append(make_capsule(at(0.115) - across * 0.13, at(0.115) + across * 0.13, 0.02, 0.02, around, shaft));
  sword.append(make_capsule(at(-0.17), at(-0.165), 0.032, 0.032, around, 1));
  const std::size_t used = std::min(sword.triangle_count(), triangles);
  const std::size_t rings = std::max<std::size_t>((triangles - used) / (2 * around), 4);
  std::vector<TubeSection> blade;
  for (std::size_t i = 0; i <= rings; ++i) {
    const double f = static_cast<double>(i) / static_cast<double>(rings);
    const double taper = 1 - smoothstep(0.82, 1.005, f) * 0.97 - 0.18 * f;
    blade.push_back({at(0.12 + 1.0 * f), 0.042 * taper, 0.008 * taper});
  }
  sword.append(make_tube(blade, around, across));
  return SkinnedShape::rigid(sword, kWristR);
}

/// Long hair over the back and shoulders, and a beard.
TrailingShape make_hair(std::size_t triangles, std::uint64_t seed) {
  const std::size_t around = detail(5, 3, triangles, 6000);
  const std::size_t points = detail(9, 4, triangles, 6000);
  const std::size_t each = 2 * around * (points - 1) + 2 * (around - 2);
  TrailingShape hair;
  hair.skinned = make_hair_cap(detail(24, 6, triangles, 16000), detail(16, 4, triangles, 16000));
  hair.lag.resize(hair.skinned.shape.positions.size(), 0.0);
  const std::size_t used = std::min(hair.triangle_count(), triangles);
  const std::size_t locks = std::max<std::size_t>((triangles - used) / each, 4);
  const double thickness = std::clamp(0.011 * std::sqrt(230.0 / static_cast<double>(locks)), 0.004, 0.03);
  Pcg32 random(seed, 11);
  for (std::size_t i = 0; i < locks; ++i) {
    const bool beard = i % 4 == 3;
    const double turn = beard ? random.uniform(-1.25, 1.25) : kPi + random.uniform(-2.1, 2.1);
    const double tilt = beard ? 0.0 : random.uniform(0.1, 1.12);
    const Vec3 out{std::sin(turn), 0, std::cos(turn)};
    const double reach = beard ? random.uniform(0.1, 0.17) : random.uniform(0.3, 0.42);
    const Vec3 root = beard ? Vec3{0.075 * out.x, random.uniform(1.58, 1.64), 0.028 + 0.082 * out.z}
                            : Vec3{0, 1.7, -0.012} +
                                  Vec3{out.x * 0.085, 0, out.z * 0.1} * std::cos(tilt * 1.4) +
                                  Vec3{0, 0.103 * std::sin(tilt * 1.4), 0};
    std::vector<Vec3> path;
    for (std::size_t k = 0; k < points; ++k) {
      const double s = static_cast<double>(k) / static_cast<double>(points - 1);
      const double wave = 0.012 * std::sin(9 * s + 6 * turn);
      const double spread = beard ? 0.03 * s : 0.035 * std::sin(std::min(2.2 * s, 1.6)) + 0.06 * s;
      path.push_back(root + out * (spread + wave * s) + Vec3{wave, -reach * std::pow(s, 1.25), 0});
    }
    add_lock(hair, path, beard ? 0.9 * thickness : thickness, around, kHead, beard ? 0.05 : 0.13);
  }
  return hair;
}

/// A pelt about the hips that follows the thighs.
TrailingShape make_kilt(std::size_t triangles) {
  const double rows = std::sqrt(static_cast<double>(std::max<std::size_t>(triangles, 96)) / 12);
  const auto nv = static_cast<std::size_t>(rows);
  const auto nu = static_cast<std::size_t>(std::max<std::size_t>(triangles, 96)) / (2 * nv);
  const auto height = [](double v) { return 1.035 - 0.44 * v; };
  TrailingShape kilt;
  kilt.skinned.shape = make_grid(
      nu, nv,
      [&](double u, double v) {
        const double angle = 2 * kPi * u;
        const double fold = 0.014 * v * std::sin(13 * angle) + 0.006 * v * std::sin(47 * angle + 9 * v);
        const double hem =
            v > 0.9 ? (v - 0.9) * (0.5 * std::sin(31 * angle) + 0.4 * std::sin(17 * angle)) : 0.0;
        const double r = 0.004 * std::sin(kPi * v * 40) * v + fold;
        return Vec3{(0.19 + 0.09 * v + r) * std::sin(angle), height(v) + hem,
                    (0.15 + 0.12 * v + r) * std::cos(angle) - 0.005};
      },
      Wrap::kU);
  for (const Vec3 p : kilt.skinned.shape.positions) {
    const double follow = 0.92 * smoothstep(1.02, 0.7, p.y);
    const double left = smoothstep(-0.13, 0.13, p.x);
    kilt.skinned.weights.push_back(
        {{kPelvis, kHipL, kHipR, 0}, {1 - follow, follow * left, follow * (1 - left), 0}});
    kilt.lag.push_back(0.06 * smoothstep(0.95, 0.55, p.y));
  }
  return kilt;
}

Shape make_belt(std::size_t around) {
  Shape belt = make_revolution({{1, -0.03}, {1.06, -0.028}, {1.08, 0}, {1.06, 0.028}, {1, 0.03}}, around);
  belt.stretch({0.188, 1, 0.148});
  belt.transform(translation({0, 1.035, -0.005}));
  belt.append(make_box({0, 1.035, 0.154}, {0.045, 0.04, 0.012}));
  return belt;
}

/// The figure with all it carries, `steps` steps of `pose`, in about `triangles` triangles.
void add_barbarian(Scene& scene, std::size_t triangles, std::size_t steps, std::uint64_t seed,
                   const Human& human, const PoseAt& pose) {
  const auto total = static_cast<double>(triangles);
  const Skeleton& skeleton = human.skeleton;
  const auto transforms = transforms_over_steps(skeleton, pose, steps);
  const auto share = [&](double f) { return static_cast<std::size_t>(f * total); };

  const RefinedBody body = refine_body(make_body_cage(human.body, skeleton, share(kBodyShare)), transforms);
  const auto leather = [&](Vec3 p) {
    const double along_arm = length(Vec3{std::abs(p.x), p.y, p.z} - skeleton.rest[kShoulderL]);
    return p.y < 0.36 || (std::abs(p.x) > 0.3 && along_arm > 0.36 && along_arm < 0.5);
  };
  add_mesh(scene, body.select("skin", kSkin, [&](Vec3 p) { return !leather(p); }));
  add_mesh(scene, body.select("boots and bracers", kLeather, leather));
  const TrailingShape hair = make_hair(share(kHairShare), seed);
  add_mesh(scene, trail("hair", hair, skeleton, pose, steps, kHair));
  add_mesh(scene, skin("sword", make_sword(skeleton, share(kSwordShare)), transforms, kSteel));
  add_mesh(scene, skin("belt", SkinnedShape::rigid(make_belt(detail(48, 6, triangles, 1e5)), kPelvis),
                       transforms, kLeather));
  add_mesh(scene, skin("eyes", make_eyes(detail(10, 3, triangles, 1e5), detail(7, 3, triangles, 1e5)),
                       transforms, {0.85f, 0.85f, 0.85f}));
  const std::size_t used = std::min(scene.triangle_count(), triangles);
  add_mesh(scene, trail("kilt", make_kilt(triangles - used), skeleton, pose, steps, kPelt));

  const Shape ground = make_grid(4, 4, [](double u, double v) { return Vec3{u * 40 - 20, 0, 20 - v * 40}; });
  add_mesh(scene, make_static_mesh("ground", ground, kGround));
}

}  // namespace

Scene make_barbarian(double scale, std::uint64_t seed) {
  Scene scene;
  scene.name = "barbarian";
  const Human human = make_human({1.0, 0.0, true});
  add_barbarian(scene, planned_triangles(scene.name, 15, scale), 15, seed, human,
                [&](double time) { return swinging_pose(human.skeleton, time); });
  scene.camera = {{-2.2f, 1.45f, 3.6f}, {0.12f, 1.15f, 0.3f}, {0, 1, 0}, 36.0f};
  return scene;
}

Scene make_barbarian_rotate(double scale, std::uint64_t seed) {
  return make_barbarian_rotate_with_steps(scale, seed, kTurningSteps);
}

Scene make_barbarian_rotate_with_steps(double scale, std::uint64_t seed, std::size_t steps) {
  Scene scene;
  scene.name = "barbarian-rotate";
  const Human human = make_human({1.0, 0.0, true});
  add_barbarian(scene, planned_triangles(scene.name, kTurningSteps, scale), steps, seed, human,
                [&](double time) { return turning_pose(human.skeleton, time); });
  scene.camera = {{0.0f, 1.5f, 4.4f}, {0.0f, 1.22f, 0.0f}, {0, 1, 0}, 33.0f};
  return scene;
}

}  // namespace stbvh::harness
