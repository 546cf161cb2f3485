/// People walking through a street: many copies of a figure, each in its own clothes, at its own pace.
#include <algorithm>
#include <array>

#include "harness/scenes/procedural/scene_makers.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "harness/scenes/procedural/shared/human.h"

namespace stbvh::harness {
namespace {

constexpr double kFreeRadius = 0.5;    ///< metres that a walker keeps from others
constexpr double kAreaEach = 1.9;      ///< square metres for each
constexpr double kWalk = 0.22;         ///< metres walked during the shutter at average pace
constexpr double kStrideLength = 1.5;  ///< metres for two steps

constexpr std::array<Vec3f, 10> kShirts{{{0.55f, 0.08f, 0.07f},
                                         {0.06f, 0.14f, 0.4f},
                                         {0.75f, 0.72f, 0.66f},
                                         {0.08f, 0.3f, 0.16f},
                                         {0.7f, 0.45f, 0.05f},
                                         {0.1f, 0.1f, 0.11f},
                                         {0.3f, 0.1f, 0.35f},
                                         {0.1f, 0.45f, 0.5f},
                                         {0.45f, 0.4f, 0.3f},
                                         {0.8f, 0.3f, 0.3f}}};
constexpr std::array<Vec3f, 5> kTrousers{{{0.05f, 0.07f, 0.16f},
                                          {0.06f, 0.055f, 0.05f},
                                          {0.3f, 0.25f, 0.16f},
                                          {0.18f, 0.2f, 0.22f},
                                          {0.25f, 0.12f, 0.07f}}};
constexpr std::array<Vec3f, 4> kSkins{
    {{0.68f, 0.43f, 0.31f}, {0.55f, 0.33f, 0.21f}, {0.3f, 0.16f, 0.09f}, {0.75f, 0.5f, 0.38f}}};
constexpr std::array<Vec3f, 4> kHairs{
    {{0.03f, 0.02f, 0.015f}, {0.14f, 0.07f, 0.03f}, {0.45f, 0.3f, 0.12f}, {0.4f, 0.38f, 0.36f}}};
constexpr std::array<HumanBuild, 4> kBuilds{
    {{0.25, 0, false}, {0.1, 0.9, false}, {0.6, 0.0, false}, {0.05, 0.6, false}}};

/// A figure at rest, by what it is made of.
struct Template {
  Skeleton skeleton;
  SkinnedShape skin, shirt, trousers, hair;
};

Template make_template(const HumanBuild& build, std::size_t triangles) {
  const Human human = make_human(build);
  Template figure;
  figure.skeleton = human.skeleton;
  const std::size_t around = detail(48, 6, triangles, 28000);
  const std::size_t rings = detail(24, 4, triangles, 28000);
  figure.hair = make_hair_cap(around, rings);
  if (build.feminine > 0.5) {
    Shape back = make_ellipsoid({0.075, 0.15, 0.055}, around, rings);
    back.transform(translation({0, 1.6, -0.085}));
    figure.hair.append(SkinnedShape::rigid(back, kHead));
  }
  const std::size_t hair = figure.hair.shape.triangle_count();
  const SkinnedShape body =
      SkinnedShape::from(human.body, human.skeleton, triangles > 2 * hair ? triangles - hair : triangles);
  const Vec3 shoulder = human.skeleton.rest[kShoulderL];
  const double sleeve = build.feminine > 0.5 ? 0.18 : 0.5;
  const auto is_shirt = [&](Vec3 p) {
    const double reach = std::abs(p.x) - shoulder.x;
    return p.y > 0.95 && p.y < 1.5 &&
           (reach < 0 || length(Vec3{std::abs(p.x), p.y, p.z} - shoulder) < sleeve);
  };
  const auto is_trousers = [](Vec3 p) { return p.y <= 0.95 && std::abs(p.x) < 0.35; };
  figure.shirt = body.select(is_shirt);
  figure.trousers = body.select(is_trousers);
  figure.skin = body.select([&](Vec3 p) { return !is_shirt(p) && !is_trousers(p); });
  return figure;
}

struct Walker {
  Vec3 place;
  double heading, turn, pace, phase, size;
  std::size_t build;
  std::array<std::size_t, 4> looks;  ///< random numbers for skin, shirt, trousers, hair

  Pose pose(const Skeleton& skeleton, double time) const {
    const double walked = kWalk * pace * (time - 0.5);
    Pose result = walking_pose(phase + 2 * kPi * walked / kStrideLength * (1 / size), 0.75 + 0.25 * pace);
    stand_on_ground(skeleton, result);
    const double yaw = heading + turn * (time - 0.5);
    const double middle = heading + 0.5 * turn * (time - 0.5);
    const Vec3 forward{std::sin(middle), 0, std::cos(middle)};
    result.root = Rigid{axis_angle({0, 1, 0}, yaw), place + forward * walked} * result.root;
    return result;
  }
};

/// Walkers in the street -z of the camera, nearest first, none closer to another than twice kFreeRadius.
std::vector<Walker> place_walkers(std::size_t count, double width, double depth, std::uint64_t seed) {
  Pcg32 random(seed, 21);
  std::vector<Walker> walkers;
  double free_radius = kFreeRadius;
  for (std::size_t attempt = 1; walkers.size() < count; ++attempt) {
    if (attempt % (200 * count) == 0) free_radius *= 0.95;
    const Vec3 place{random.uniform(-0.5, 0.5) * width, 0, -depth * random.uniform()};
    const bool taken = std::any_of(walkers.begin(), walkers.end(), [&](const Walker& other) {
      return length(other.place - place) < 2 * free_radius;
    });
    if (taken) continue;
    Walker walker{};
    walker.place = place;
    const double way = random.uniform();
    walker.heading = way < 0.55 ? 0.0 : way < 0.85 ? kPi : way < 0.93 ? 0.5 * kPi : -0.5 * kPi;
    walker.heading += random.uniform(-0.4, 0.4);
    walker.turn = random.uniform() < 0.4 ? random.uniform(-0.7, 0.7) : random.uniform(-0.1, 0.1);
    walker.pace = random.uniform(0.7, 1.3);
    walker.phase = random.uniform(0, 2 * kPi);
    walker.size = random.uniform(0.92, 1.06);
    walker.build = random.next() % kBuilds.size();
    for (std::size_t& look : walker.looks) look = random.next() >> 8;
    walkers.push_back(walker);
  }
  std::sort(walkers.begin(), walkers.end(),
            [](const Walker& a, const Walker& b) { return a.place.z > b.place.z; });
  return walkers;
}

/// `part` in the size of the walker, over the steps of `transforms`.
void add_part(Scene& scene, const SkinnedShape& part, const Walker& walker,
              const std::vector<std::vector<Rigid>>& transforms, Vec3f color) {
  Mesh mesh = skin("walker", part, transforms, color);
  const Vec3f ground = to_float(walker.place);
  const auto size = static_cast<float>(walker.size);
  for (VertexBuffer& step : mesh.steps) {
    for (std::size_t i = 0; i < step.size(); ++i) {
      step[i] = {ground.x + (step[i].x - ground.x) * size, step[i].y * size,
                 ground.z + (step[i].z - ground.z) * size};
    }
  }
  add_mesh(scene, std::move(mesh));
}

void add_walker(Scene& scene, const Template& figure, const Walker& walker, std::size_t steps) {
  const auto transforms = transforms_over_steps(
      figure.skeleton, [&](double time) { return walker.pose(figure.skeleton, time); }, steps);
  add_part(scene, figure.skin, walker, transforms, kSkins[walker.looks[0] % kSkins.size()]);
  add_part(scene, figure.shirt, walker, transforms, kShirts[walker.looks[1] % kShirts.size()]);
  add_part(scene, figure.trousers, walker, transforms, kTrousers[walker.looks[2] % kTrousers.size()]);
  add_part(scene, figure.hair, walker, transforms, kHairs[walker.looks[3] % kHairs.size()]);
}

/// Pavement, and a row of houses with windows on each side.
void add_street(Scene& scene, double width, double depth) {
  const double half = 0.5 * width + 1.5;
  const Shape ground = make_grid(8, 16, [&](double u, double v) {
    return Vec3{(u - 0.5) * 8 * half, 0, 8 - v * (depth + 60)};
  });
  add_mesh(scene, make_static_mesh("pavement", ground, {0.36f, 0.34f, 0.32f}));
  Shape walls, windows;
  const auto houses = static_cast<int>(std::ceil((depth + 14) / 8));
  for (int i = 0; i < houses; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const double height = 7 + 1.7 * ((i * 7 + (side > 0 ? 3 : 0)) % 4);
      const Vec3 center{side * (half + 4), 0.5 * height, 4 - 8.0 * i};
      walls.append(make_box(center, {4, 0.5 * height, 3.9}));
      for (int window = 0; window < 9; ++window) {
        const Vec3 place{side * half, 1.8 + 2.4 * (window / 3), center.z + 2.4 * (window % 3 - 1)};
        if (place.y + 1 < height) windows.append(make_box(place, {0.06, 0.75, 0.5}));
      }
    }
  }
  add_mesh(scene, make_static_mesh("houses", walls, {0.55f, 0.43f, 0.32f}));
  add_mesh(scene, make_static_mesh("windows", windows, {0.09f, 0.13f, 0.17f}));
}

}  // namespace

Scene make_crowd(double scale, std::uint64_t seed) {
  Scene scene;
  scene.name = "crowd";
  std::size_t people = 0;
  for (const StepGroup& group : planned_groups(scene.name)) people += plan_crowd(group.steps, scale).figures;
  const double width = std::sqrt(static_cast<double>(people) * kAreaEach / 1.5);
  const double depth = 1.5 * width;
  const std::vector<Walker> walkers = place_walkers(people, width, depth, seed);

  // Those near the camera have the most steps.
  std::size_t next = 0;
  for (const std::size_t steps : {15u, 6u, 2u}) {
    const CrowdPlan plan = plan_crowd(steps, scale);
    std::array<Template, kBuilds.size()> figures;
    for (std::size_t b = 0; b < kBuilds.size(); ++b)
      figures[b] = make_template(kBuilds[b], plan.triangles_per_figure);
    for (std::size_t i = 0; i < plan.figures; ++i, ++next)
      add_walker(scene, figures[walkers[next].build], walkers[next], steps);
  }
  add_street(scene, width, depth);
  scene.camera = {{0.6f, 3.0f, 4.2f}, {0.0f, 0.9f, -4.0f}, {0, 1, 0}, 50.0f};
  return scene;
}

}  // namespace stbvh::harness
