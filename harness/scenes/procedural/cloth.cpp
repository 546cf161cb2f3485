/// A square cloth over a ball on a post, waving in a gust.
#include <algorithm>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "harness/scenes/procedural/shared/cloth_simulation.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSteps = 9;
constexpr std::size_t kParticles = 72;  ///< along each edge
constexpr double kHalfSide = 1.25;      ///< metres
constexpr Vec3 kBall{0, 1.25, 0};
constexpr double kBallRadius = 0.5;
constexpr double kThickness = 0.012;    ///< distance that the cloth keeps
constexpr double kSettle = 1.5;         ///< seconds before the shutter opens
constexpr double kShutter = 0.16;       ///< seconds
constexpr std::size_t kSubsteps = 144;  ///< of the shutter, however many steps there are
constexpr double kSettleSubstep = 1.0 / 900;

ClothWorld make_world(std::uint64_t seed) {
  Pcg32 random(seed, 31);
  const double phase = random.uniform(0, 2 * kPi);
  ClothWorld world;
  world.drag = 4;
  world.friction = 0.35;
  world.wind = [phase](Vec3 p, double time) {
    const double gust = smoothstep(0.6, 1.2, time);
    const double wave =
        std::sin(5.0 * p.x - 11 * time + phase) + 0.7 * std::sin(4.0 * p.z + 7 * p.y - 8 * time);
    return Vec3{4.4 + 2.2 * wave, 0.6 * wave, 1.2 + 1.5 * std::sin(3.0 * p.x + 6 * time + phase)} * gust;
  };
  world.push_out = [](Vec3 p, double) {
    const Vec3 d = p - kBall;
    if (length(d) < kBallRadius + kThickness) p = kBall + normalize(d) * (kBallRadius + kThickness);
    const double post = std::hypot(p.x, p.z);
    if (p.y < kBall.y && post < 0.09)
      p = Vec3{p.x * 0.09 / std::max(post, 1e-6), p.y, p.z * 0.09 / std::max(post, 1e-6)};
    return Vec3{p.x, std::max(p.y, kThickness), p.z};
  };
  return world;
}

void add_surroundings(Scene& scene) {
  Shape ball = make_ellipsoid({kBallRadius, kBallRadius, kBallRadius}, 64, 33);
  ball.transform(translation(kBall));
  add_mesh(scene, make_static_mesh("ball", ball, {0.5f, 0.5f, 0.55f}));
  Shape post = make_revolution({{0.4, 0}, {0.4, 0.05}, {0.12, 0.08}, {0.06, 0.14}, {0.06, 0.8}}, 48);
  add_mesh(scene, make_static_mesh("post", post, {0.25f, 0.16f, 0.1f}));
  const Shape floor = make_grid(8, 8, [](double u, double v) { return Vec3{30 * u - 15, 0, 15 - 30 * v}; });
  add_mesh(scene, make_static_mesh("floor", floor, {0.45f, 0.42f, 0.38f}));
}

}  // namespace

Scene make_cloth(double scale, std::uint64_t seed) {
  return make_cloth_with_steps(scale, seed, kSteps);
}

Scene make_cloth_with_steps(double scale, std::uint64_t seed, std::size_t steps) {
  Scene scene;
  scene.name = "cloth";
  const std::size_t triangles = planned_triangles(scene.name, kSteps, scale);
  const auto rows = static_cast<std::size_t>(std::sqrt(0.5 * static_cast<double>(triangles)));
  const std::size_t columns = triangles / (2 * rows);

  const auto flat = [](double u, double v) {
    return Vec3{(2 * u - 1) * kHalfSide, 0, (2 * v - 1) * kHalfSide};
  };
  const Rigid start = translation({0.05, kBall.y + kBallRadius + 0.03, -0.03}) * rotation({0, 1, 0}, 0.5);
  Cloth cloth(
      kParticles, kParticles, false, [&](double u, double v) { return start.apply(flat(u, v)); }, flat);
  const ClothWorld world = make_world(seed);
  cloth.run(world, 0, kSettle, kSettleSubstep);

  Mesh& mesh = scene.meshes.emplace_back();
  mesh.name = "cloth";
  mesh.material.color = {0.55f, 0.06f, 0.07f};
  const Shape grid = make_grid(columns, rows, [](double u, double v) { return Vec3{u, v, 0}; });
  mesh.indices = grid.indices;
  const auto substep_begin = [](std::size_t s) {
    return kSettle + kShutter * static_cast<double>(s) / static_cast<double>(kSubsteps);
  };
  Cloth before = cloth;
  std::size_t done = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    const double substeps = static_cast<double>(kSubsteps) * step_time(k, steps);
    for (; static_cast<double>(done) < substeps - 1e-9; ++done) {
      before = cloth;
      cloth.run(world, substep_begin(done), substep_begin(done + 1), kShutter / kSubsteps);
    }
    const double f = std::min(1 - (static_cast<double>(done) - substeps), 1.0);
    VertexBuffer& buffer = mesh.steps.emplace_back(grid.positions.size());
    for_all(buffer.size(), [&](std::size_t i) {
      const Vec3 p = grid.positions[i];
      buffer[i] = to_float(before.surface(p.x, p.y) * (1 - f) + cloth.surface(p.x, p.y) * f);
    });
  }
  add_surroundings(scene);
  scene.camera = {{1.0f, 2.0f, 4.2f}, {0.25f, 1.0f, 0.0f}, {0, 1, 0}, 36.0f};
  return scene;
}

}  // namespace stbvh::harness
