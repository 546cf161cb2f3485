/// A turning torus on a ground, the smallest scene of all: 4,000 triangles with 9 steps at its default scale.
#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/shared/machine_parts.h"

namespace stbvh::harness {
namespace {

constexpr double kTriangles = 40e3;
constexpr double kRadius = 1;
constexpr double kThickness = 0.35;
constexpr Vec3 kCenter{0, 1.15, 0};
constexpr double kTurn = 0.5 * kPi;  ///< over the shutter

}  // namespace

Scene make_torus(double scale, std::uint64_t /*seed*/) {
  Part ring{"torus", 9, {0.7, 0.35, 0.08}, {}, {}};
  const Motion turning = rigid_motion([](double time) {
    return rotation_about(kCenter, {1, 0, 0}, kTurn * time);
  });
  ring.add(torus(kCenter, {0.2, 1, 0.3}, kRadius, kThickness), {{}, turning, 1});
  Scene scene;
  scene.name = "torus";
  scene.meshes = tessellate({ring}, scaled_count(kTriangles, scale));
  const Shape ground = make_grid(1, 1, [](double u, double v) { return Vec3{u * 12 - 6, -0.4, 6 - v * 12}; });
  add_mesh(scene, make_static_mesh("ground", ground, {0.4f, 0.42f, 0.38f}));
  scene.camera = {{0.8f, 2.4f, 4.6f}, {0.0f, 0.95f, 0.0f}, {0, 1, 0}, 38.0f};
  return scene;
}

}  // namespace stbvh::harness
