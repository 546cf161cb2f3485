/// A human figure of blobs on a skeleton, standing at the origin with its feet on y = 0, looking along +z,
/// its arms held away from the body.
#pragma once

#include <vector>

#include "harness/scenes/procedural/shared/skeleton.h"

namespace stbvh::harness {

/// Joints of the figure; sides follow the figure's own left (+x) and right (-x).
enum HumanJoint : std::size_t {
  kPelvis,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kShoulderL,
  kElbowL,
  kWristL,
  kShoulderR,
  kElbowR,
  kWristR,
  kHipL,
  kKneeL,
  kAnkleL,
  kToeL,
  kHipR,
  kKneeR,
  kAnkleR,
  kToeR,
  kHumanJoints
};

struct HumanBuild {
  double muscle = 0.2;    ///< 0 slight to 1 heavy
  double feminine = 0.0;  ///< 0 to 1: shoulders, hips, waist
  bool fists = false;     ///< closed hands
};

struct Human {
  Skeleton skeleton;
  ImplicitBody body;
};

Human make_human(const HumanBuild& build);

/// Short hair: the part of an ellipsoid of `around` x `rings` that covers the scalp.
SkinnedShape make_hair_cap(std::size_t around, std::size_t rings);

/// Both eyeballs, which follow the head.
SkinnedShape make_eyes(std::size_t around, std::size_t rings);

/// The joint of the other side's arm or leg, right for left.
std::size_t mirrored(std::size_t joint);

/// Everything hanging at rest, the root unmoved.
Pose rest_pose();

/// Arms at the sides.
Pose standing_pose();

/// A step of a walk: `phase` in radians (2 pi for two steps), `stride` about 1 for a brisk one.
Pose walking_pose(double phase, double stride);

/// Unit vector from one joint at rest to another.
Vec3 rest_direction(const Skeleton& skeleton, std::size_t from, std::size_t to);

/// Moves the root up or down until the lowest foot touches y = 0.
void stand_on_ground(const Skeleton& skeleton, Pose& pose);

}  // namespace stbvh::harness
