#include <fmt/format.h>

#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "harness/microbenchmarks/benchmarks.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/frozen_scene.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kRays = 20'000;  ///< of each time
constexpr std::string_view kScenes[] = {
    "llama", "barbershop", "train", "crowd", "barbarian", "barbarian-rotate", "cloth", "wheels", "dancer"};
constexpr std::string_view kStructures[] = {"stbvh-direct", "embree"};
/// Irregular, so that they stand differently to the steps of every mesh.
constexpr std::array kTimes{0.07f, 0.21f, 0.36f, 0.49f, 0.64f, 0.77f, 0.93f};

using Structures = std::map<std::string_view, std::unique_ptr<StructureUnderTest>>;

Structures build_all(const Scene& scene) {
  Structures structures;
  for (std::string_view name : kStructures) structures[name] = build_structure(name, scene, 0);
  return structures;
}

/// A scene as it is at one time, its trees, and rays at that time.
struct Moment {
  Scene scene;
  Structures structures;
  std::map<RayKind, std::vector<Ray>> rays;
};

/// A moving scene, its trees, and the scene at rest at each of kTimes. Only one is kept at a time.
class ThawedScene {
 public:
  explicit ThawedScene(std::string_view name) {
    const ProceduralScene* source = find_procedural_scene(name);
    scene_ = source->make(source->default_scale, 1);
    structures_ = build_all(scene_);
    for (float time : kTimes) {
      Moment& moment = *moments_.emplace_back(std::make_unique<Moment>());
      moment.scene = frozen(scene_, time);
      moment.structures = build_all(moment.scene);
      for (RayKind kind : {RayKind::kBounce, RayKind::kUniform}) {
        std::vector<Ray>& rays = moment.rays[kind];
        rays = make_rays(kind, moment.scene, *moment.structures.at("embree"), kRays, 1).rays;
        for (Ray& ray : rays) ray.time = time;
      }
    }
  }

  static const ThawedScene& get(std::string_view name) {
    static std::string_view current;
    static std::unique_ptr<ThawedScene> scene;
    if (current != name) {
      scene.reset();
      scene = std::make_unique<ThawedScene>(name);
      current = name;
    }
    return *scene;
  }

  const StructureUnderTest& structure(std::string_view name) const { return *structures_.at(name); }
  const std::vector<std::unique_ptr<Moment>>& moments() const { return moments_; }

 private:
  Scene scene_;
  Structures structures_;
  std::vector<std::unique_ptr<Moment>> moments_;
};

double seconds_of(const StructureUnderTest& structure, std::span<const Ray> rays, std::span<HitRecord> hits) {
  const auto begin = std::chrono::steady_clock::now();
  structure.intersect(rays, hits);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

TraversalCounters visits_of(const StructureUnderTest& structure, std::span<const Ray> rays) {
  TraversalCounters counters;
  for (const Ray& ray : rays) {
    Hit hit;
    structure.intersect_one_counted(ray, hit, counters);
  }
  return counters;
}

/// The same rays through the moving scene, and through the scene built anew for the moment that they are of:
/// a tree that any tree of the moving scene could at best be as good as, in its visits.
void measure_frozen(benchmark::State& state, std::string_view scene_name, RayKind kind,
                    std::string_view structure_name) {
  const ThawedScene& scene = ThawedScene::get(scene_name);
  const StructureUnderTest& moving = scene.structure(structure_name);
  std::vector<HitRecord> hits(kRays), still_hits(kRays);
  double moving_s = 0, frozen_s = 0;
  std::size_t different = 0;
  for (auto _ : state) {
    double moving_now = 0;
    for (const auto& moment : scene.moments()) {
      const std::span<const Ray> rays = moment->rays.at(kind);
      frozen_s += seconds_of(*moment->structures.at(structure_name), rays, still_hits);
      moving_now += seconds_of(moving, rays, hits);
      for (std::size_t i = 0; i < kRays; ++i) different += hits[i].is_hit() != still_hits[i].is_hit();
    }
    moving_s += moving_now;
    state.SetIterationTime(moving_now);
  }
  const double rays = static_cast<double>(kRays * kTimes.size());
  const double iterations = static_cast<double>(state.iterations());
  if (static_cast<double>(different) > 0.002 * rays * iterations) report_wrong_answer(state);
  state.counters["moving_ns"] = 1e9 * moving_s / (rays * iterations);
  state.counters["frozen_ns"] = 1e9 * frozen_s / (rays * iterations);
  if (!moving.has_counters()) return;
  TraversalCounters moving_visits, frozen_visits;
  for (const auto& moment : scene.moments()) {
    const std::span<const Ray> of_moment = moment->rays.at(kind);
    const TraversalCounters m = visits_of(moving, of_moment);
    const TraversalCounters f = visits_of(*moment->structures.at(structure_name), of_moment);
    moving_visits.nodes += m.nodes;
    moving_visits.leaves += m.leaves;
    frozen_visits.nodes += f.nodes;
    frozen_visits.leaves += f.leaves;
  }
  state.counters["moving_nodes"] = static_cast<double>(moving_visits.nodes) / rays;
  state.counters["moving_leaves"] = static_cast<double>(moving_visits.leaves) / rays;
  state.counters["frozen_nodes"] = static_cast<double>(frozen_visits.nodes) / rays;
  state.counters["frozen_leaves"] = static_cast<double>(frozen_visits.leaves) / rays;
}

}  // namespace

void register_frozen() {
  for (std::string_view scene : kScenes) {
    for (RayKind kind : {RayKind::kBounce, RayKind::kUniform}) {
      for (std::string_view structure : kStructures) {
        const std::string name = fmt::format("frozen/{}/{}/{}", scene, ray_kind_name(kind), structure);
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
          measure_frozen(state, scene, kind, structure);
        })->UseManualTime();
      }
    }
  }
}

}  // namespace stbvh::harness
