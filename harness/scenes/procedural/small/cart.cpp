/// A hay cart on the road: 2,600 triangles, wheels of 9 steps under a body of 2.
#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/shared/spoked_wheel.h"

namespace stbvh::harness {
namespace {

constexpr double kTriangles = 2600;
constexpr double kTravel = 0.6;  ///< metres over the shutter, along -x
constexpr double kRadius = 0.55;

Rigid cart_pose(double time) {
  return translation({kTravel * (0.5 - time), 0, 0});
}

}  // namespace

Scene make_cart(double scale, std::uint64_t /*seed*/) {
  Part boards{"boards", 2, {0.42, 0.24, 0.1}, {}, {}}, hay{"hay", 2, {0.72, 0.58, 0.2}, {}, {}};
  Part wood{"wheels", 9, {0.3, 0.16, 0.07}, {}, {}}, iron{"tyres", 9, {0.1, 0.1, 0.11}, {}, {}};
  const Placement rolling{{}, rigid_motion(cart_pose), 1};
  boards.add(box({0, 0.75, 0}, {1.35, 0.06, 0.62}), rolling);
  for (const double side : {-1.0, 1.0}) {
    boards.add(box({0, 1.05, 0.62 * side}, {1.35, 0.24, 0.03}), rolling);
    boards.add(box({1.38 * side, 1.0, 0}, {0.03, 0.19, 0.62}), rolling);
    boards.add(cylinder({-1.35, 0.72, 0.35 * side}, {-3.0, 0.95, 0.3 * side}, 0.045, 0.035), rolling);
  }
  hay.add(ellipsoid({0, 1.15, 0}, {1.25, 0.55, 0.56}), rolling);
  for (const double x : {-0.9, 0.9}) {
    boards.add(cylinder({x, kRadius, -0.8}, {x, kRadius, 0.8}, 0.05, 0.05), rolling);
    for (const double side : {-1.0, 1.0}) {
      const Rigid hub = translation({x, kRadius, 0.78 * side});
      const Motion turning = rigid_motion([hub](double time) {
        return cart_pose(time) * hub * rotation({0, 0, 1}, kTravel / kRadius * time) * inverse(hub);
      });
      const WheelPatches wheel = make_spoked_wheel({0.96 * kRadius, 0.07, 0.08, 10, 0.025, 0.08, 0.2, 0});
      wood.add(join({wheel.rim, wheel.spokes, wheel.hub}), {hub, turning, 1});
      iron.add(flat_ring(0.96 * kRadius, kRadius, 0.09), {hub, turning, 1});
    }
  }
  Scene scene;
  scene.name = "cart";
  scene.meshes = tessellate({boards, hay, wood, iron}, scaled_count(kTriangles, scale));
  const Shape road = make_grid(1, 1, [](double u, double v) { return Vec3{u * 16 - 8, 0, 8 - v * 16}; });
  add_mesh(scene, make_static_mesh("road", road, {0.37f, 0.34f, 0.28f}));
  scene.camera = {{-2.6f, 1.9f, 4.4f}, {-0.35f, 0.75f, 0.0f}, {0, 1, 0}, 38.0f};
  return scene;
}

}  // namespace stbvh::harness
