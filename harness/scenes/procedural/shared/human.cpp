#include "harness/scenes/procedural/shared/human.h"

#include <algorithm>

namespace stbvh::harness {
namespace {

/// Heights of the soles below the ankle and toe joints.
constexpr double kAnkleHeight = 0.085;
constexpr double kToeHeight = 0.03;
/// The tip of the big toe against the toe joint, and its radius.
constexpr Vec3 kToeTip{0, -0.006, 0.06};
constexpr double kToeRadius = 0.022;

/// Adds blobs, and their mirror images with the right side's joint.
class Modeller {
 public:
  explicit Modeller(ImplicitBody& body) : body_(body) {}

  void middle(const Blob& blob) { body_.add(blob); }
  void both(Blob blob) {
    body_.add(blob);
    blob.a.x = -blob.a.x;
    blob.b.x = -blob.b.x;
    blob.joint = mirrored(blob.joint);
    body_.add(blob);
  }

 private:
  ImplicitBody& body_;
};

Vec3 along(Vec3 a, Vec3 b, double f, Vec3 offset = {}) {
  return lerp(a, b, f) + offset;
}

Skeleton make_skeleton(const HumanBuild& build) {
  const double shoulder = 0.185 + 0.045 * build.muscle - 0.025 * build.feminine;
  const double hip = 0.09 + 0.008 * build.feminine;
  const Vec3 arm = normalize(Vec3{0.74, -0.67, 0.02});
  Skeleton s;
  s.add(kNoJoint, {0, 0.96, 0});
  s.add(kPelvis, {0, 1.08, 0});
  s.add(kSpine, {0, 1.24, -0.005});
  s.add(kChest, {0, 1.47, -0.02});
  s.add(kNeck, {0, 1.58, 0.0});
  const Vec3 shoulder_l{shoulder, 1.43, -0.02};
  for (const double side : {1.0, -1.0}) {
    const auto mirror = [side](Vec3 p) { return Vec3{side * p.x, p.y, p.z}; };
    const std::size_t upper = s.add(kChest, mirror(shoulder_l));
    const std::size_t elbow = s.add(upper, mirror(shoulder_l + arm * 0.285));
    s.add(elbow, mirror(shoulder_l + arm * 0.54));
  }
  for (const double side : {1.0, -1.0}) {
    const std::size_t upper = s.add(kPelvis, {side * hip, 0.92, 0});
    const std::size_t knee = s.add(upper, {side * (hip + 0.022), 0.5, 0.012});
    const std::size_t ankle = s.add(knee, {side * (hip + 0.035), kAnkleHeight, -0.02});
    s.add(ankle, {side * (hip + 0.045), kToeHeight, 0.11});
  }
  return s;
}

void add_torso(Modeller& m, const HumanBuild& build) {
  const double heavy = build.muscle;
  const double fem = build.feminine;
  const double waist = 0.098 + 0.022 * heavy - 0.016 * fem;
  m.both({{0.065 + 0.01 * fem, 0.94, 0}, {0.05, 1.02, 0}, 0.105, 0.095, kPelvis, 0.05, {1, 1, 0.95}});
  m.both({{0.07, 0.9, -0.045}, {0.07, 0.93, -0.05}, 0.085, 0.085, kPelvis, 0.03});
  m.both({{0.045, 1.02, 0}, {0.045, 1.16, 0.005}, waist, waist, kSpine, 0.05, {1, 1, 0.9}});
  m.both({{0.06 + 0.02 * heavy, 1.24, 0},
          {0.085 + 0.045 * heavy, 1.37, -0.01},
          0.105,
          0.105 + 0.012 * heavy,
          kChest,
          0.05,
          {1, 1, 0.93}});
  m.both({{0.02, 1.5, -0.03}, {0.15, 1.45, -0.03}, 0.05 + 0.026 * heavy, 0.05 + 0.012 * heavy, kChest, 0.04});
  if (heavy > 0.5) {
    m.both({{0.062, 1.35, 0.078}, {0.14, 1.375, 0.055}, 0.066, 0.055, kChest, 0.014, {1, 1, 0.8}});
    m.both({{0.15, 1.34, -0.045}, {0.095, 1.18, -0.03}, 0.075, 0.045, kChest, 0.03});
    for (const double y : {1.04, 1.105, 1.17, 1.235})
      m.both({{0.036, y, 0.092}, {0.042, y, 0.092}, 0.033, 0.03, y > 1.12 ? kChest : kSpine, 0.01});
  }
  if (fem > 0.3) m.both({{0.078, 1.3, 0.072}, {0.082, 1.3, 0.078}, 0.062, 0.05, kChest, 0.03});
}

void add_head(Modeller& m, const HumanBuild& build) {
  const double heavy = build.muscle;
  m.middle({{0, 1.44, -0.025}, {0, 1.58, 0.005}, 0.054 + 0.03 * heavy, 0.05 + 0.02 * heavy, kNeck, 0.03});
  m.middle({{0, 1.695, -0.012}, {0, 1.70, -0.012}, 0.1, 0.1, kHead, 0.03, {0.86, 1, 1}});
  m.middle({{0, 1.66, 0.028}, {0, 1.592, 0.06}, 0.074, 0.036, kHead, 0.04, {0.88, 1, 1}});
  m.both({{0.04, 1.645, 0.058}, {0.048, 1.65, 0.04}, 0.022, 0.024, kHead, 0.03});      // cheeks
  m.both({{0.012, 1.694, 0.086}, {0.042, 1.692, 0.074}, 0.013, 0.012, kHead, 0.012});  // brows
  m.middle({{0, 1.682, 0.09}, {0, 1.648, 0.112}, 0.009, 0.014, kHead, 0.01});          // nose
  m.middle({{-0.012, 1.614, 0.086}, {0.012, 1.614, 0.086}, 0.013, 0.013, kHead, 0.012, {1, 0.6, 1}});  // lips
  m.both(
      {{0.03, 1.675, 0.1}, {0.033, 1.674, 0.098}, 0.014, 0.012, kHead, 0.012, {1, 1, 1}, true});    // sockets
  m.both({{0.084, 1.67, -0.005}, {0.09, 1.695, -0.014}, 0.016, 0.022, kHead, 0.008, {0.5, 1, 1}});  // ears
}

void add_hand(Modeller& m, const Skeleton& s, const HumanBuild& build) {
  const Vec3 wrist = s.rest[kWristL];
  const Vec3 arm = normalize(wrist - s.rest[kElbowL]);
  const Vec3 forward{0, 0, 1};
  const Vec3 palm = normalize(cross(forward, arm));  // away from the body
  m.both({wrist, wrist + arm * 0.07, 0.026, 0.033, kWristL, 0.02, {0.85, 0.85, 1}});
  const double length_of[4] = {0.075, 0.085, 0.08, 0.062};
  for (int finger = 0; finger < 4; ++finger) {
    const double z = 0.032 - 0.021 * finger;
    const Vec3 knuckle = wrist + arm * 0.085 + forward * z;
    if (build.fists) {
      const Vec3 middle = knuckle + arm * 0.012 - palm * 0.03;
      m.both({knuckle, middle, 0.0125, 0.0125, kWristL, 0.006});
      m.both({middle, middle - arm * 0.035 - palm * 0.004, 0.012, 0.011, kWristL, 0.006});
    } else {
      const Vec3 middle = knuckle + arm * (0.5 * length_of[finger]) - palm * 0.008;
      m.both({knuckle, middle, 0.0105, 0.0095, kWristL, 0.006});
      m.both(
          {middle, middle + arm * (0.45 * length_of[finger]) - palm * 0.016, 0.0095, 0.008, kWristL, 0.006});
    }
  }
  const Vec3 thumb = wrist + arm * 0.03 + forward * 0.028;
  m.both({thumb, thumb + arm * 0.05 + forward * 0.025 - palm * (build.fists ? 0.03 : 0.008), 0.015, 0.0105,
          kWristL, 0.01});
}

void add_arms(Modeller& m, const Skeleton& s, const HumanBuild& build) {
  const double heavy = build.muscle;
  const Vec3 shoulder = s.rest[kShoulderL], elbow = s.rest[kElbowL], wrist = s.rest[kWristL];
  m.both(
      {shoulder, along(shoulder, elbow, 0.3), 0.058 + 0.032 * heavy, 0.05 + 0.02 * heavy, kShoulderL, 0.04});
  m.both(
      {along(shoulder, elbow, 0.15), elbow, 0.044 + 0.012 * heavy, 0.038 + 0.007 * heavy, kShoulderL, 0.03});
  m.both({along(shoulder, elbow, 0.5, {0, 0, 0.014}), along(shoulder, elbow, 0.7, {0, 0, 0.012}),
          0.038 + 0.018 * heavy, 0.036 + 0.014 * heavy, kShoulderL, 0.02});
  m.both({elbow, along(elbow, wrist, 0.35), 0.039 + 0.006 * heavy, 0.042 + 0.012 * heavy, kElbowL, 0.03});
  m.both({along(elbow, wrist, 0.35), wrist, 0.042 + 0.012 * heavy, 0.027 + 0.006 * heavy, kElbowL, 0.03});
  add_hand(m, s, build);
}

void add_legs(Modeller& m, const Skeleton& s, const HumanBuild& build) {
  const double heavy = build.muscle;
  const Vec3 hip = s.rest[kHipL], knee = s.rest[kKneeL], ankle = s.rest[kAnkleL], toe = s.rest[kToeL];
  m.both({along(hip, knee, 0.04), knee, 0.086 + 0.016 * heavy, 0.055 + 0.006 * heavy, kHipL, 0.035});
  m.both({along(hip, knee, 0.3, {0.012, 0, 0.022}), along(hip, knee, 0.65, {0.006, 0, 0.02}),
          0.062 + 0.02 * heavy, 0.05 + 0.014 * heavy, kHipL, 0.03});
  m.both({knee + Vec3{0, 0, 0.012}, knee + Vec3{0, -0.03, 0.012}, 0.05, 0.046, kKneeL, 0.02});
  m.both({knee, ankle, 0.05 + 0.004 * heavy, 0.035 + 0.004 * heavy, kKneeL, 0.03});
  m.both({along(knee, ankle, 0.12, {0, 0, -0.022}), along(knee, ankle, 0.42, {0, 0, -0.024}),
          0.046 + 0.01 * heavy, 0.042 + 0.014 * heavy, kKneeL, 0.03});
  m.both({ankle + Vec3{0, -0.042, -0.028}, ankle + Vec3{0, -0.02, 0.02}, 0.04, 0.042, kAnkleL, 0.03});
  m.both({ankle + Vec3{0, -0.03, 0.02}, toe, 0.042, 0.034, kAnkleL, 0.03, {1, 0.9, 1}});
  m.both({toe + Vec3{-0.012, -0.002, 0.0},
          toe + Vec3{-0.016, -0.006, 0.06},
          0.032,
          0.022,
          kToeL,
          0.02,
          {1, 0.85, 1}});
  m.both({toe + Vec3{0.018, -0.004, 0.0},
          toe + Vec3{0.02, -0.008, 0.042},
          0.03,
          0.02,
          kToeL,
          0.02,
          {1, 0.85, 1}});
}

}  // namespace

Human make_human(const HumanBuild& build) {
  Human human{make_skeleton(build), {}};
  Modeller modeller(human.body);
  add_torso(modeller, build);
  add_head(modeller, build);
  add_arms(modeller, human.skeleton, build);
  add_legs(modeller, human.skeleton, build);
  return human;
}

SkinnedShape make_hair_cap(std::size_t around, std::size_t rings) {
  Shape scalp = make_ellipsoid({0.091, 0.106, 0.106}, around, rings);
  scalp.transform(rotation({1, 0, 0}, -0.5));
  scalp.transform(translation({0, 1.705, -0.022}));
  return SkinnedShape::rigid(scalp, kHead).select([](Vec3 p) { return p.y - 1.2 * p.z > 1.66; });
}

SkinnedShape make_eyes(std::size_t around, std::size_t rings) {
  Shape eyes;
  for (const double side : {-1.0, 1.0}) {
    Shape eye = make_ellipsoid({0.012, 0.008, 0.01}, around, rings);
    eye.transform(translation({side * 0.031, 1.675, 0.078}));
    eyes.append(eye);
  }
  return SkinnedShape::rigid(eyes, kHead);
}

std::size_t mirrored(std::size_t joint) {
  if (joint >= kShoulderL && joint <= kWristL) return joint + (kShoulderR - kShoulderL);
  if (joint >= kHipL && joint <= kToeL) return joint + (kHipR - kHipL);
  return joint;
}

Pose rest_pose() {
  return {std::vector<Quaternion>(kHumanJoints), {}};
}

Pose standing_pose() {
  Pose pose = rest_pose();
  pose.turns[kShoulderL] = axis_angle({0, 0, 1}, -0.66);
  pose.turns[kShoulderR] = axis_angle({0, 0, 1}, 0.66);
  return pose;
}

Pose walking_pose(double phase, double stride) {
  constexpr Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
  Pose pose = standing_pose();
  const double swing = std::sin(phase);
  for (const double side : {1.0, -1.0}) {
    const bool left = side > 0;
    const double leg = side * swing;  // positive: the leg is in front
    const double lift = std::fmax(0.0, side * std::cos(phase));
    pose.turns[left ? kHipL : kHipR] = axis_angle(kX, -stride * (0.08 + 0.5 * leg));
    pose.turns[left ? kKneeL : kKneeR] =
        axis_angle(kX, stride * (0.18 + 0.85 * lift * lift + 0.1 * leg * leg));
    pose.turns[left ? kAnkleL : kAnkleR] = axis_angle(kX, stride * (-0.25 * leg - 0.1 * lift));
    pose.turns[left ? kToeL : kToeR] = axis_angle(kX, -stride * 0.5 * std::fmax(0.0, -leg));
    const Quaternion down = pose.turns[left ? kShoulderL : kShoulderR];
    pose.turns[left ? kShoulderL : kShoulderR] = axis_angle(kX, stride * 0.55 * leg) * down;
    const Quaternion bend = axis_angle(kX, -0.25 - stride * 0.3 * std::fmax(0.0, -leg));
    pose.turns[left ? kElbowL : kElbowR] = conjugate(down) * bend * down;
  }
  pose.turns[kPelvis] = axis_angle(kY, -0.12 * stride * swing) * axis_angle(kZ, 0.04 * std::cos(phase));
  pose.turns[kSpine] = axis_angle(kY, 0.12 * stride * swing) * axis_angle(kX, 0.05 * stride);
  pose.turns[kChest] = axis_angle(kY, 0.14 * stride * swing);
  pose.turns[kHead] = axis_angle(kY, -0.12 * stride * swing);
  return pose;
}

Vec3 rest_direction(const Skeleton& skeleton, std::size_t from, std::size_t to) {
  return normalize(skeleton.rest[to] - skeleton.rest[from]);
}

void stand_on_ground(const Skeleton& skeleton, Pose& pose) {
  const std::vector<Rigid> moved = skin_transforms(skeleton, pose);
  double lowest = 1e9;
  const auto touch = [&](std::size_t joint, Vec3 offset, double radius) {
    lowest = std::fmin(lowest, moved[joint].apply(skeleton.rest[joint] + offset).y - radius);
  };
  for (const std::size_t ankle : {kAnkleL, kAnkleR}) touch(ankle, {}, kAnkleHeight);
  for (const std::size_t toe : {kToeL, kToeR}) {
    touch(toe, {}, kToeHeight);
    touch(toe, kToeTip, kToeRadius);
  }
  pose.root.translation.y -= lowest;
}

}  // namespace stbvh::harness
