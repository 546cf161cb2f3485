/// A dancer in a pirouette, her skirt flying out.
#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "harness/scenes/procedural/shared/cloth_simulation.h"
#include "harness/scenes/procedural/shared/human.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSteps = 15;
constexpr double kShutter = 0.11;  ///< seconds
constexpr double kTurnsPerSecond = 1.25;
constexpr double kSettle = 1.2;  ///< seconds before the shutter opens
constexpr double kSubstep = 1.0 / 720;
constexpr std::size_t kSkirtColumns = 96;  ///< particles around
constexpr std::size_t kSkirtRows = 22;
constexpr double kSkirtLength = 0.5;
constexpr double kWaistHeight = 1.04;
constexpr double kWaistRadius = 0.145;
/// Distance that the skirt keeps from the legs.
constexpr double kThickness = 0.015;

/// Shares of the triangles; the skirt takes what is left.
constexpr double kBodyShare = 0.5;

/// One leg on its toes, the other drawn up to the knee before the shutter opens, then opening to the side,
/// arms from rounded to open.
Pose dance(const Skeleton& s, double seconds) {
  constexpr Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
  const double open = smoothstep(-0.25, 0.3, seconds);
  const double drawn = smoothstep(-1.05, -0.4, seconds);
  Pose pose = standing_pose();
  pose.turns[kAnkleL] = axis_angle(kX, 0.95);
  pose.turns[kToeL] = axis_angle(kX, 0.45);
  pose.turns[kHipL] = axis_angle(kZ, -0.1);
  pose.turns[kHipR] = axis_angle(kY, (-0.75 - 0.25 * open) * drawn) * axis_angle(kX, -1.25 * drawn);
  pose.turns[kKneeR] = axis_angle(kX, lerp(2.0, 1.25, open) * drawn);
  pose.turns[kAnkleR] = axis_angle(kX, 0.8);
  pose.turns[kToeR] = axis_angle(kX, 0.35);
  pose.turns[kSpine] = axis_angle(kX, -0.06) * axis_angle(kY, 0.1 * open);
  pose.turns[kChest] = axis_angle(kX, -0.1) * axis_angle(kZ, 0.06);
  pose.turns[kHead] = axis_angle(kY, 0.35 - 0.7 * open) * axis_angle(kX, -0.1);
  const Vec3 left = rest_direction(s, kShoulderL, kWristL), right = rest_direction(s, kShoulderR, kWristR);
  pose.turns[kShoulderL] = align(left, {0, 0, 1}, {0.5, 0.85, 0.22}, {-0.85, 0.5, 0});
  pose.turns[kElbowL] = axis_angle(cross(left, {0, 0, 1}), 0.75);
  pose.turns[kShoulderR] =
      align(right, {0, 0, 1}, lerp(Vec3{-0.55, -0.2, 0.8}, Vec3{-0.95, 0.05, 0.15}, open), {0.5, 0.1, 1});
  pose.turns[kElbowR] = axis_angle(cross(right, {0, 0, 1}), lerp(0.9, 0.35, open));
  stand_on_ground(s, pose);
  // About the standing foot.
  const double x = s.rest[kToeL].x - 0.03;
  const Rigid spin = rotation({0, 1, 0}, 2 * kPi * kTurnsPerSecond * (seconds - 0.5 * kShutter));
  pose.root = spin * translation({-x, 0, -0.05}) * pose.root;
  return pose;
}

struct Capsule {
  std::size_t joint;
  Vec3 a, b;
  double radius;
};

std::vector<Capsule> leg_capsules(const Skeleton& s) {
  std::vector<Capsule> capsules;
  for (const std::size_t hip : {kHipL, kHipR}) {
    capsules.push_back({hip, s.rest[hip], s.rest[hip + 1], 0.085});
    capsules.push_back({hip + 1, s.rest[hip + 1], s.rest[hip + 2], 0.06});
  }
  capsules.push_back({kPelvis, {-0.065, 0.94, -0.01}, {0.065, 0.94, -0.01}, 0.105});
  return capsules;
}

Vec3 push_out_of(Vec3 p, Vec3 a, Vec3 b, double radius) {
  const double f = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
  const Vec3 axis = lerp(a, b, f);
  return length(p - axis) < radius ? axis + normalize(p - axis) * radius : p;
}

/// The skirt, simulated from before the shutter on.
class Skirt {
 public:
  Skirt(const Skeleton& skeleton, std::uint64_t seed)
      : skeleton_(skeleton), capsules_(leg_capsules(skeleton)), cloth_(make_cloth()) {
    cloth_.spin(2 * kPi * kTurnsPerSecond);
    Pcg32 random(seed, 41);
    const double phase = random.uniform(0, 2 * kPi);
    world_.drag = 2.5;
    world_.friction = 0.05;
    world_.wind = [phase](Vec3 p, double time) {
      // The air turns with her, nearly.
      const Vec3 swirl = cross(Vec3{0, 0.9 * 2 * kPi * kTurnsPerSecond, 0}, p);
      return swirl + Vec3{0.5 * std::sin(9 * p.z + 5 * time + phase), 0.6 * std::sin(11 * p.x + 7 * time),
                          0.4 * std::sin(8 * p.x)};
    };
    world_.push_out = [this](Vec3 p, double) {
      for (const Capsule& c : posed_) p = push_out_of(p, c.a, c.b, c.radius + kThickness);
      return Vec3{p.x, std::max(p.y, kThickness), p.z};
    };
    world_.pin = [this](std::size_t i, double) { return waist_[i]; };
  }

  /// Moves on to `end` seconds; the obstacles stand still within a substep.
  void advance(double begin, double end) {
    const auto count = static_cast<std::size_t>(std::ceil((end - begin) / kSubstep - 1e-9));
    for (std::size_t s = 0; s < count; ++s) {
      const double dt = (end - begin) / static_cast<double>(count);
      const double time = begin + dt * static_cast<double>(s + 1);
      pose(time);
      cloth_.run(world_, time - dt, time, dt);
    }
  }

  const Cloth& cloth() const { return cloth_; }

 private:
  static Vec3 annulus(double u, double v, double fullness, double drop) {
    const double angle = 2 * kPi * u;
    const double r = kWaistRadius + fullness * kSkirtLength * v;
    return {r * std::sin(angle), kWaistHeight - drop * kSkirtLength * v,
            (r - 0.025 * (1 - v)) * std::cos(angle)};
  }

  Cloth make_cloth() const {
    const Rigid pelvis = skin_transforms(skeleton_, dance(skeleton_, -kSettle))[kPelvis];
    // Cut as a cone that is fuller than the one in which it starts.
    return Cloth(
        kSkirtColumns, kSkirtRows, true,
        [&](double u, double v) { return pelvis.apply(annulus(u, v, 0.8, 0.6)); },
        [](double u, double v) { return annulus(u, v, 0.95, 0.31); });
  }

  void pose(double time) {
    const std::vector<Rigid> moved = skin_transforms(skeleton_, dance(skeleton_, time));
    posed_ = capsules_;
    for (Capsule& c : posed_) {
      c.a = moved[c.joint].apply(c.a);
      c.b = moved[c.joint].apply(c.b);
    }
    waist_.resize(kSkirtColumns);
    for (std::size_t i = 0; i < kSkirtColumns; ++i)
      waist_[i] = moved[kPelvis].apply(annulus(static_cast<double>(i) / kSkirtColumns, 0, 0, 0));
  }

  const Skeleton& skeleton_;
  std::vector<Capsule> capsules_, posed_;
  std::vector<Vec3> waist_;
  Cloth cloth_;
  ClothWorld world_;
};

/// The cloth at each step.
std::vector<Cloth> simulate_skirt(const Skeleton& skeleton, std::uint64_t seed) {
  Skirt skirt(skeleton, seed);
  std::vector<Cloth> steps;
  double now = -kSettle;
  for (std::size_t k = 0; k < kSteps; ++k) {
    const double then = kShutter * step_time(k, kSteps);
    skirt.advance(now, then);
    now = then;
    steps.push_back(skirt.cloth());
  }
  return steps;
}

Mesh make_skirt(const std::vector<Cloth>& steps, std::size_t triangles) {
  const auto rows =
      static_cast<std::size_t>(std::sqrt(static_cast<double>(std::max<std::size_t>(triangles, 24)) / 8));
  const std::size_t columns = std::max<std::size_t>(triangles / (2 * rows), 3);
  const Shape grid = make_grid(
      columns, rows,
      [](double u, double v) {
        return Vec3{u, v, 0};
      },
      Wrap::kU);
  Mesh mesh;
  mesh.name = "skirt";
  mesh.material.color = {0.6f, 0.05f, 0.12f};
  mesh.indices = grid.indices;
  for (const Cloth& cloth : steps) {
    VertexBuffer& buffer = mesh.steps.emplace_back(grid.positions.size());
    for_all(buffer.size(), [&](std::size_t i) {
      buffer[i] = to_float(cloth.surface(grid.positions[i].x, grid.positions[i].y));
    });
  }
  return mesh;
}

SkinnedShape make_hairdo(std::size_t triangles) {
  SkinnedShape hair = make_hair_cap(detail(72, 6, triangles, 3e5), detail(48, 4, triangles, 3e5));
  Shape bun =
      make_ellipsoid({0.05, 0.045, 0.05}, detail(48, 4, triangles, 3e5), detail(32, 3, triangles, 3e5));
  bun.transform(translation({0, 1.765, -0.115}));
  hair.append(SkinnedShape::rigid(bun, kHead));
  return hair;
}

void add_stage(Scene& scene) {
  const Shape floor = make_grid(20, 20, [](double u, double v) { return Vec3{16 * u - 8, 0, 8 - 16 * v}; });
  add_mesh(scene, make_static_mesh("stage", floor, {0.33f, 0.2f, 0.11f}));
  const Shape curtain = make_grid(400, 4, [](double u, double v) {
    const double x = 14 * u - 7;
    return Vec3{x, 6 * v, -4.5 + 0.14 * std::sin(7 * x) + 0.05 * std::sin(17 * x)};
  });
  add_mesh(scene, make_static_mesh("curtain", curtain, {0.08f, 0.1f, 0.22f}));
}

}  // namespace

Scene make_dancer(double scale, std::uint64_t seed) {
  Scene scene;
  scene.name = "dancer";
  const std::size_t triangles = planned_triangles(scene.name, kSteps, scale);
  const Human human = make_human({0.05, 1.0, false});
  const Skeleton& skeleton = human.skeleton;
  const auto transforms = transforms_over_steps(
      skeleton, [&](double time) { return dance(skeleton, kShutter * time); }, kSteps);

  std::vector<Cloth> skirt;
  SkinnedShape body;
  tbb::parallel_invoke([&] { skirt = simulate_skirt(skeleton, seed); },
                       [&] {
                         const double share = kBodyShare * static_cast<double>(triangles);
                         body = SkinnedShape::from(human.body, skeleton, static_cast<std::size_t>(share));
                       });
  check_cancelled();
  const auto is_shoe = [](Vec3 p) { return p.y < 0.1; };
  const auto is_bodice = [](Vec3 p) {
    return p.y > 0.84 && p.y < 1.37 + 0.4 * std::abs(p.x) && std::abs(p.x) < 0.16 &&
           p.y - 0.5 * std::abs(p.x) > 0.8;
  };
  add_mesh(scene, skin("skin", body.select([&](Vec3 p) { return !is_shoe(p) && !is_bodice(p); }), transforms,
                       {0.7f, 0.45f, 0.33f}));
  add_mesh(scene, skin("bodice", body.select(is_bodice), transforms, {0.6f, 0.05f, 0.12f}));
  add_mesh(scene, skin("shoes", body.select(is_shoe), transforms, {0.75f, 0.35f, 0.38f}));
  add_mesh(scene, skin("eyes", make_eyes(detail(10, 3, triangles, 1e5), detail(7, 3, triangles, 1e5)),
                       transforms, {0.3f, 0.3f, 0.3f}));
  add_mesh(scene, skin("hair", make_hairdo(triangles), transforms, {0.07f, 0.03f, 0.015f}));
  const std::size_t used = std::min(scene.triangle_count(), triangles);
  add_mesh(scene, make_skirt(skirt, triangles - used));
  add_stage(scene);
  scene.camera = {{-0.5f, 1.35f, 4.4f}, {0.0f, 1.1f, 0.0f}, {0, 1, 0}, 34.0f};
  return scene;
}

}  // namespace stbvh::harness
