// The paper's train: 0.3M triangles with 3 steps (here the landscape going by) and 2.0M with 17.
#include <algorithm>
#include <iterator>

#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/train/train_pieces.h"

namespace stbvh::harness {

TrainParts::TrainParts(std::size_t steps) {
  struct Color {
    const char* name;
    Vec3 color;
  };
  constexpr std::array<Color, kPaintCount> kColors{{{"black iron", {0.035, 0.036, 0.04}},
                                                    {"green cladding", {0.03, 0.16, 0.07}},
                                                    {"red paint", {0.55, 0.035, 0.025}},
                                                    {"brass", {0.80, 0.52, 0.12}},
                                                    {"steel", {0.52, 0.54, 0.57}},
                                                    {"coal", {0.015, 0.015, 0.017}},
                                                    {"steam", {0.88, 0.88, 0.90}},
                                                    {"maroon", {0.30, 0.03, 0.03}},
                                                    {"cream", {0.78, 0.68, 0.46}},
                                                    {"glass", {0.05, 0.08, 0.12}},
                                                    {"roof", {0.20, 0.20, 0.21}}}};
  for (const Color& color : kColors) parts_.push_back({color.name, steps, color.color, {}, {}});
}

double train_richness(double scale) {
  return std::clamp(scale / 0.1, 0.05, 1.0);
}

Motion sway(double phase) {
  return rigid_motion([phase](double time) {
    const double angle = 2 * kPi * time + phase;
    const Vec3 bob{0, 0.012 * std::sin(1.3 * angle), 0.01 * std::cos(angle)};
    return translation(bob) * rotation_about({0, 0.9, 0}, {1, 0, 0}, 0.011 * std::sin(angle));
  });
}

void add_axle(TrainParts& train, double x, const SpokedWheel& wheel, Paint spokes, double angle) {
  const Vec3 center{x, wheel.radius, 0};
  const Motion turning = spin(center, -kTravel / wheel.radius);
  const WheelPatches patches = make_spoked_wheel(wheel);
  for (const double side : {-1.0, 1.0}) {
    Rigid pose =
        translation(center + Vec3{0, 0, side * kHalfGauge}) * rotation({0, 0, 1}, angle + side * 0.2);
    if (side < 0) pose = pose * rotation({0, 1, 0}, kPi);
    train[Paint::kSteel].add(patches.rim, {pose, turning, 1.4});
    train[spokes].add(patches.spokes, {pose, turning, 2});
    train[spokes].add(patches.hub, {pose, turning, 2});
  }
  const Vec3 half_axle{0, 0, kHalfGauge};
  train[Paint::kBlack].add(cylinder(center - half_axle, center + half_axle, 0.07, 0.07), {{}, turning, 1});
}

Scene make_train(double scale, std::uint64_t seed) {
  const double richness = train_richness(scale);
  TrainParts train(17);
  add_locomotive(train, seed);
  add_tender(train, richness, seed);
  const int carriages = std::clamp(static_cast<int>(scale * 150), 1, 3);
  for (int i = 0; i < carriages; ++i) add_carriage(train, -20.2 - 17.2 * i, 1.9 * i + 0.7);

  Scene scene;
  scene.name = "train";
  scene.meshes = tessellate(make_landscape(3, richness, seed), scaled_count(0.3e6, scale));
  std::vector<Mesh> moving = tessellate(train.all(), scaled_count(2.0e6, scale));
  scene.meshes.insert(scene.meshes.end(), std::make_move_iterator(moving.begin()),
                      std::make_move_iterator(moving.end()));
  scene.camera = {{14.0f, 3.0f, 11.5f}, {0.2f, 2.3f, 0.0f}, {0, 1, 0}, 40.0f};
  return scene;
}

}  // namespace stbvh::harness
