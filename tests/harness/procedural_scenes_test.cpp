/// The procedural scenes: counts by step as in the paper's table, sound meshes, the same bits every time, and
/// the motion their names promise.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "harness/scenes/procedural/barbarian/body_cage.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/procedural/scene_plan.h"
#include "harness/scenes/procedural/shared/implicit_body.h"
#include "harness/scenes/procedural/shared/mesh_tools.h"
#include "stbvh/mesh_view.h"

namespace stbvh::harness {
namespace {

constexpr double kSmallScale = 0.02;

/// Scenes whose counts scene_plan.h plans.
const std::vector<std::string> kFigureScenes{"llama", "crowd", "barbarian", "barbarian-rotate",
                                             "cloth", "dancer"};

Scene make(std::string_view name, double scale, std::uint64_t seed = 1) {
  return find_procedural_scene(name)->make(scale, seed);
}

/// At kSmallScale; made once.
const Scene& small_scene(std::string_view name) {
  static std::map<std::string_view, Scene> made;
  const auto [entry, is_new] = made.try_emplace(find_procedural_scene(name)->name);
  if (is_new) entry->second = make(name, kSmallScale);
  return entry->second;
}

std::map<std::size_t, double> moving_triangles(const Scene& scene) {
  std::map<std::size_t, double> by_steps;
  for (const Mesh& mesh : scene.meshes) {
    if (!mesh.is_static()) by_steps[mesh.steps.size()] += static_cast<double>(mesh.triangle_count());
  }
  return by_steps;
}

const Mesh& mesh_named(const Scene& scene, std::string_view name) {
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.name == name) return mesh;
  }
  throw std::out_of_range(std::string(name));
}

std::uint64_t hash_of(const Scene& scene) {
  std::uint64_t hash = 14695981039346656037u;
  const auto mix = [&](std::uint32_t word) { hash = (hash ^ word) * 1099511628211u; };
  for (const Mesh& mesh : scene.meshes) {
    for (const std::uint32_t i : mesh.indices) mix(i);
    for (const VertexBuffer& step : mesh.steps) {
      for (const Vec3f& p : step.span()) {
        std::uint32_t words[3];
        std::memcpy(words, &p, sizeof(words));
        for (const std::uint32_t word : words) mix(word);
      }
    }
  }
  return hash;
}

TEST(ProceduralScenes, TheRegistryHoldsAllInOrder) {
  const std::vector<std::string> expected{
      "llama",  "barbershop",  "train", "crowd",  "barbarian", "barbarian-rotate", "cloth", "wheels",
      "dancer", "static-city", "torus", "walker", "cart"};
  std::vector<std::string> names;
  for (const ProceduralScene& scene : procedural_scenes()) {
    names.emplace_back(scene.name);
    EXPECT_FALSE(scene.description.empty());
    EXPECT_GT(scene.default_scale, 0);
    EXPECT_EQ(find_procedural_scene(scene.name), &scene);
  }
  EXPECT_EQ(names, expected);
  EXPECT_EQ(find_procedural_scene("teapot"), nullptr);
  EXPECT_EQ(find_procedural_scene(""), nullptr);
}

TEST(ProceduralScenes, AtScaleOneThePlansAreThePapersTable) {
  EXPECT_EQ(planned_triangles("llama", 3, 1), 7'000'000u);
  EXPECT_EQ(planned_triangles("llama", 9, 1), 1'700'000u);
  EXPECT_EQ(planned_triangles("crowd", 2, 1), 7'500'000u);
  EXPECT_EQ(planned_triangles("crowd", 6, 1), 2'800'000u);
  EXPECT_EQ(planned_triangles("crowd", 15, 1), 100'000u);
  EXPECT_EQ(planned_triangles("barbarian", 15, 1), 100'000u);
  EXPECT_EQ(planned_triangles("barbarian-rotate", 9, 1), 100'000u);
  EXPECT_EQ(planned_triangles("cloth", 9, 1), 500'000u);
  EXPECT_EQ(planned_triangles("dancer", 15, 1), 300'000u);
}

TEST(ProceduralScenes, WhatIsDealtOutAddsUpToThePlan) {
  for (const double scale : {0.01, 0.05, 1.0}) {
    for (const std::size_t steps : {2u, 6u, 15u}) {
      const auto planned = static_cast<double>(planned_triangles("crowd", steps, scale));
      const CrowdPlan crowd = plan_crowd(steps, scale);
      EXPECT_NEAR(static_cast<double>(crowd.figures * crowd.triangles_per_figure), planned, 0.01 * planned);
    }
    const LlamaPlan llama = plan_llama(scale);
    const auto wool = static_cast<double>(llama.long_strands * strand_triangles(kLongStrandSegments));
    const auto near = static_cast<double>(llama.body_triangles +
                                          llama.short_strands * strand_triangles(kShortStrandSegments));
    EXPECT_NEAR(wool, 7.0e6 * scale, 0.01 * 7.0e6 * scale);
    EXPECT_NEAR(near, 1.7e6 * scale, 0.01 * 1.7e6 * scale);
  }
  EXPECT_GE(plan_crowd(2, 1).figures, 250u);
  EXPECT_GE(plan_crowd(2, 0.02).figures, 40u);
}

TEST(ProceduralScenes, CountsByStepsFollowThePlan) {
  for (const std::string& name : kFigureScenes) {
    std::map<std::size_t, double> found = moving_triangles(small_scene(name));
    EXPECT_EQ(found.size(), planned_groups(name).size()) << name;
    for (const StepGroup& group : planned_groups(name)) {
      const double planned = group.triangles * kSmallScale;
      EXPECT_NEAR(found[group.steps], planned, 0.04 * planned) << name << ", " << group.steps << " steps";
    }
  }
}

TEST(ProceduralScenes, TheMachinesHaveTheStepsOfTheTable) {
  const std::map<std::string, std::map<std::size_t, double>> table{
      {"barbershop", {{3, 1.4e6}, {5, 2.8e6}, {9, 3.9e6}}}, {"train", {{3, 0.3e6}, {17, 2.0e6}}}};
  for (const auto& [name, groups] : table) {
    std::map<std::size_t, double> found = moving_triangles(make(name, 0.05));
    for (const auto& [steps, triangles] : groups)
      EXPECT_NEAR(found[steps], triangles * 0.05, 0.05 * triangles * 0.05)
          << name << ", " << steps << " steps";
  }
}

void expect_sound(const Scene& scene) {
  EXPECT_FALSE(scene.meshes.empty());
  for (const Mesh& mesh : scene.meshes) {
    const std::string where = scene.name + ", " + mesh.name;
    ASSERT_FALSE(mesh.steps.empty()) << where;
    EXPECT_LE(mesh.steps.size(), kMaxSceneSteps) << where;
    EXPECT_GT(mesh.indices.size(), 0u) << where;
    EXPECT_EQ(mesh.indices.size() % 3, 0u) << where;
    std::size_t bad = 0;
    for (const std::uint32_t i : mesh.indices) bad += i >= mesh.steps[0].size() ? 1u : 0u;
    for (const VertexBuffer& step : mesh.steps) {
      ASSERT_EQ(step.size(), mesh.steps[0].size()) << where;
      for (const Vec3f& p : step.span())
        bad += std::abs(p.x) + std::abs(p.y) + std::abs(p.z) < 1e4f ? 0u : 1u;
    }
    EXPECT_EQ(bad, 0u) << where;
  }
}

TEST(ProceduralScenes, MeshesAreSound) {
  for (const ProceduralScene& scene : procedural_scenes()) {
    const Scene& made = small_scene(scene.name);
    EXPECT_EQ(made.name, scene.name);
    expect_sound(made);
  }
}

TEST(ProceduralScenes, TinyScalesStillMakeAScene) {
  for (const ProceduralScene& scene : procedural_scenes()) expect_sound(scene.make(1e-6, 1));
}

TEST(ProceduralScenes, TheSameBitsOnAnyNumberOfThreads) {
  for (const ProceduralScene& scene : procedural_scenes()) {
    const std::uint64_t of_many = hash_of(small_scene(scene.name));
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(hash_of(make(scene.name, kSmallScale)), of_many) << scene.name;
  }
}

TEST(ProceduralScenes, AnotherSeedIsAnotherScene) {
  for (const std::string& name : kFigureScenes)
    EXPECT_NE(hash_of(small_scene(name)), hash_of(make(name, kSmallScale, 2))) << name;
}

TEST(ProceduralScenes, ScalesThatCannotBeAreRefused) {
  for (const std::string& name : kFigureScenes) {
    for (const double scale : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()})
      EXPECT_THROW(make(name, scale), std::invalid_argument) << name << " " << scale;
  }
}

/// Largest distance between a vertex of the first or last step of `a` and the same of `b`.
double largest_distance(const Scene& a, const Scene& b) {
  double largest = 0;
  for (std::size_t m = 0; m < a.meshes.size(); ++m) {
    for (const bool is_last : {false, true}) {
      const VertexBuffer& p = is_last ? a.meshes[m].steps.back() : a.meshes[m].steps.front();
      const VertexBuffer& q = is_last ? b.meshes[m].steps.back() : b.meshes[m].steps.front();
      for (std::size_t i = 0; i < p.size(); ++i) {
        largest = std::max({largest, std::abs(double{p[i].x} - q[i].x), std::abs(double{p[i].y} - q[i].y),
                            std::abs(double{p[i].z} - q[i].z)});
      }
    }
  }
  return largest;
}

TEST(ProceduralScenes, TheSameMotionWithAnyNumberOfSteps) {
  std::size_t tried = 0;
  for (const ProceduralScene& scene : procedural_scenes()) {
    if (scene.make_with_steps == nullptr) continue;
    const Scene& usual = small_scene(scene.name);
    const std::size_t usual_steps = moving_triangles(usual).begin()->first;
    EXPECT_EQ(hash_of(scene.make_with_steps(kSmallScale, 1, usual_steps)), hash_of(usual)) << scene.name;
    for (const std::size_t steps : {2u, 33u, 129u}) {
      const Scene made = scene.make_with_steps(kSmallScale, 1, steps);
      expect_sound(made);
      const auto by_steps = moving_triangles(made);
      ASSERT_EQ(by_steps.size(), 1u) << scene.name;
      EXPECT_EQ(by_steps.begin()->first, steps) << scene.name;
      EXPECT_EQ(made.triangle_count(), usual.triangle_count()) << scene.name;
      EXPECT_LT(largest_distance(made, usual), 1e-5) << scene.name << ", " << steps << " steps (metres)";
    }
    ++tried;
  }
  EXPECT_EQ(tried, 2u);
}

TEST(ProceduralScenes, BarbarianRotateTurnsHalfATurn) {
  const Scene& scene = small_scene("barbarian-rotate");
  for (const char* name : {"belt", "eyes"}) {
    const Mesh& mesh = mesh_named(scene, name);
    const VertexBuffer& first = mesh.steps.front();
    const VertexBuffer& last = mesh.steps.back();
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_NEAR(last[i].x, -first[i].x, 1e-5f);
      EXPECT_NEAR(last[i].y, first[i].y, 1e-5f);
      EXPECT_NEAR(last[i].z, -first[i].z, 1e-5f);
    }
  }
}

TEST(ProceduralScenes, TheBarbariansSwordSweepsALargeArc) {
  const Scene& scene = small_scene("barbarian");
  const Mesh& sword = mesh_named(scene, "sword");
  double farthest = 0, off_the_chord = 0;
  const VertexBuffer& middle = sword.steps[sword.steps.size() / 2];
  for (std::size_t i = 0; i < middle.size(); ++i) {
    const auto at = [i](const VertexBuffer& b) { return to_double(b[i]); };
    const Vec3 a = at(sword.steps.front()), b = at(sword.steps.back());
    farthest = std::fmax(farthest, length(b - a));
    off_the_chord = std::fmax(off_the_chord, length(at(middle) - lerp(a, b, 0.5)));
  }
  EXPECT_GT(farthest, 1.5);
  EXPECT_GT(off_the_chord, 0.4);
}

ImplicitBody two_blobs() {
  ImplicitBody body;
  body.add({{0, 0, 0}, {0.6, 0.2, 0}, 0.3, 0.15, 0, 0.05});
  body.add({{-0.1, 0.4, 0}, {-0.1, 0.8, 0.1}, 0.12, 0.2, 0, 0.1, {1, 1, 0.6}});
  return body;
}

TEST(BodyCage, TheRefinedCageIsTheBody) {
  const ImplicitBody body = two_blobs();
  Skeleton skeleton;
  skeleton.add(kNoJoint, {0, 0, 0});
  const std::vector<std::vector<Rigid>> transforms{{translation({0, 0, 0})}, {translation({0, 3, 0})}};
  for (const auto& [triangles, level] : {std::pair{5'000u, 0u}, {40'000u, 1u}, {150'000u, 2u}}) {
    const BodyCage cage = make_body_cage(body, skeleton, triangles);
    EXPECT_EQ(cage.level, level) << triangles;
    const RefinedBody refined = refine_body(cage, transforms);
    const double count = static_cast<double>(refined.moving.triangle_count());
    EXPECT_NEAR(count, triangles, 0.03 * triangles);
    ASSERT_EQ(refined.moving.steps.size(), 2u);
    double farthest = 0;
    for (std::size_t v = 0; v < refined.rest.size(); ++v) {
      const Vec3f p = refined.rest[v], moved = refined.moving.steps[1][v];
      farthest = std::fmax(farthest, std::abs(body.distance(to_double(p))));
      EXPECT_NEAR(moved.y, p.y + 3, 1e-6f);
    }
    EXPECT_LT(farthest, 2e-3);
    const Mesh left = refined.select("left", {}, [](Vec3 p) { return p.x < 0; });
    const Mesh right = refined.select("right", {}, [](Vec3 p) { return p.x >= 0; });
    EXPECT_EQ(left.triangle_count() + right.triangle_count(), refined.moving.triangle_count());
    for (const std::uint32_t i : right.indices) EXPECT_GT(right.steps[0][i].x, -0.05f);
  }
}

TEST(ImplicitBody, ItsSurfaceIsClosedAndOutward) {
  const ImplicitBody body = two_blobs();
  const Shape shape = polygonise_to_count(body, 5000);
  EXPECT_NEAR(static_cast<double>(shape.triangle_count()), 5000, 150);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  double volume = 0;
  for (std::size_t t = 0; t < shape.indices.size(); t += 3) {
    Vec3 corner[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = shape.indices[t + k], b = shape.indices[t + (k + 1) % 3];
      ++edges[{a, b}];
      corner[k] = shape.positions[a];
    }
    volume += dot(corner[0], cross(corner[1], corner[2])) / 6;
  }
  for (const auto& [edge, uses] : edges) {
    EXPECT_EQ(uses, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
  EXPECT_GT(volume, 0.1);
  for (const Vec3 p : shape.positions) EXPECT_LT(std::abs(body.distance(p)), 2e-3);
}

}  // namespace
}  // namespace stbvh::harness
