/// A single walker, as coarse as figures in games are: one mesh of 5,000 triangles with 9 steps.
#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/shared/human.h"
#include "harness/scenes/procedural/shared/machine_parts.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSteps = 9;
constexpr double kTriangles = 5000;
constexpr double kPhase = 0.9;         ///< radians of the walk, at the middle of the shutter
constexpr double kWalked = 0.4;        ///< metres over the shutter
constexpr double kStrideLength = 1.5;  ///< metres for two steps

}  // namespace

Scene make_walker(double scale, std::uint64_t /*seed*/) {
  Scene scene;
  scene.name = "walker";
  const std::size_t triangles = scaled_count(kTriangles, scale);
  const Human human = make_human({0.3, 0.2, false});
  const auto walk = [&](double time) {
    const double walked = kWalked * (time - 0.5);
    Pose pose = walking_pose(kPhase + 2 * kPi * walked / kStrideLength, 1.1);
    stand_on_ground(human.skeleton, pose);
    pose.root = translation({0, 0, walked}) * pose.root;
    return pose;
  };
  add_mesh(scene, skin("walker", SkinnedShape::from(human.body, human.skeleton, triangles),
                       transforms_over_steps(human.skeleton, walk, kSteps), {0.55f, 0.33f, 0.21f}));
  scene.camera = {{2.2f, 1.3f, 2.6f}, {0.0f, 0.92f, 0.0f}, {0, 1, 0}, 36.0f};
  return scene;
}

}  // namespace stbvh::harness
