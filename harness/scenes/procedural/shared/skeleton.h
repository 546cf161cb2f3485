/// Joints, poses, and meshes that follow them smoothly.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "harness/scenes/procedural/shared/implicit_body.h"
#include "harness/scenes/procedural/shared/mesh_tools.h"

namespace stbvh::harness {

inline constexpr std::size_t kNoJoint = static_cast<std::size_t>(-1);

/// Joints in an order in which parents come first; rest frames are parallel to the world's axes.
struct Skeleton {
  std::vector<std::size_t> parents;  ///< kNoJoint for the root
  std::vector<Vec3> rest;

  std::size_t add(std::size_t parent, Vec3 position);
};

/// How each joint is turned against its parent, and where the root goes.
struct Pose {
  std::vector<Quaternion> turns;  ///< by joint, about its own position
  Rigid root;                     ///< after the root joint's own turn
};

/// For each joint, the motion from the rest position to `pose`.
std::vector<Rigid> skin_transforms(const Skeleton& skeleton, const Pose& pose);

/// Pose at a time; times before 0 are asked for too, by what trails behind.
using PoseAt = std::function<Pose(double time)>;

/// Transforms of a skeleton at each of `steps` steps.
std::vector<std::vector<Rigid>> transforms_over_steps(const Skeleton& skeleton, const PoseAt& pose,
                                                      std::size_t steps);

/// A body and the joints that each of its vertices follows.
struct SkinnedShape {
  Shape shape;
  std::vector<SkinWeights> weights;

  /// The surface of `body` in about `triangles` triangles.
  static SkinnedShape from(const ImplicitBody& body, const Skeleton& skeleton, std::size_t triangles);
  /// `shape` following one joint rigidly.
  static SkinnedShape rigid(const Shape& shape, std::size_t joint);
  void append(const SkinnedShape& other);
  /// The triangles for which choose(centroid at rest) is true, with only their vertices.
  SkinnedShape select(const std::function<bool(Vec3)>& choose) const;
};

/// Linear blend skinning of one point.
Vec3 skin_point(Vec3 p, const SkinWeights& weights, const std::vector<Rigid>& transforms);

/// The mesh of `skinned` over the steps of `transforms`.
Mesh skin(std::string name, const SkinnedShape& skinned, const std::vector<std::vector<Rigid>>& transforms,
          Vec3f color);

}  // namespace stbvh::harness
