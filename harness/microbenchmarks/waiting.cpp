#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "harness/microbenchmarks/benchmarks.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kRays = 40'000;
constexpr std::string_view kScenes[] = {"barbarian", "crowd", "dancer", "static-city"};
constexpr std::string_view kStructures[] = {"embree", "embree-4v", "stbvh", "stbvh-direct"};
constexpr RayKind kKinds[] = {RayKind::kBounce, RayKind::kUniform, RayKind::kShadow};

/// A scene at its default scale with all structures, none of which fits into the caches. Built when the first
/// benchmark that needs it runs; only one at a time.
class FullScene {
 public:
  explicit FullScene(std::string_view name) {
    const ProceduralScene* source = find_procedural_scene(name);
    scene_ = source->make(source->default_scale, 1);
    for (std::string_view structure : kStructures) {
      structures_[structure] = build_structure(structure, scene_, 0);
    }
  }

  static FullScene& get(std::string_view name) {
    static std::string_view current;
    static std::unique_ptr<FullScene> scene;
    if (current != name) {
      scene.reset();
      scene = std::make_unique<FullScene>(name);
      current = name;
    }
    return *scene;
  }

  /// Made when they are first asked for.
  const RaySet& rays(RayKind kind) {
    const auto [entry, is_new] = rays_.try_emplace(kind);
    if (is_new) entry->second = make_rays(kind, scene_, *structures_.at(kStructures[0]), kRays, 1);
    return entry->second;
  }
  const StructureUnderTest& structure(std::string_view name) const { return *structures_.at(name); }

 private:
  Scene scene_;
  std::map<std::string_view, std::unique_ptr<StructureUnderTest>> structures_;
  std::map<RayKind, RaySet> rays_;
};

double seconds_of(const StructureUnderTest& structure, std::span<const Ray> rays, bool any_hit,
                  std::span<HitRecord> hits) {
  const auto begin = std::chrono::steady_clock::now();
  any_hit ? structure.occluded(rays, hits) : structure.intersect(rays, hits);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Traces the rays once each, then twice each in a row: the second time all that a ray needs is in the
/// nearest caches, and its branches have just been taken. What is left is computing.
void measure_waiting(benchmark::State& state, std::string_view scene_name, RayKind kind,
                     std::string_view structure_name) {
  FullScene& scene = FullScene::get(scene_name);
  const StructureUnderTest& structure = scene.structure(structure_name);
  const RaySet& set = scene.rays(kind);
  std::vector<Ray> twice;
  for (const Ray& ray : set.rays) twice.insert(twice.end(), 2, ray);
  std::vector<HitRecord> hits(twice.size());
  double first_s = 0, again_s = 0;
  for (auto _ : state) {
    const double once = seconds_of(structure, set.rays, set.any_hit(), std::span(hits).first(kRays));
    const double both = seconds_of(structure, twice, set.any_hit(), hits);
    first_s += once;
    again_s += both - once;
    state.SetIterationTime(once);
  }
  for (std::size_t i = 0; i < hits.size(); i += 2) {
    if (hits[i].geom_id != hits[i + 1].geom_id || hits[i].prim_id != hits[i + 1].prim_id) {
      report_wrong_answer(state);
      return;
    }
  }
  const double per_ray_ns = 1e9 / (static_cast<double>(state.iterations()) * static_cast<double>(kRays));
  state.counters["first_ns"] = first_s * per_ray_ns;
  state.counters["again_ns"] = again_s * per_ray_ns;
}

}  // namespace

void register_waiting() {
  for (std::string_view scene : kScenes) {
    for (RayKind kind : kKinds) {
      for (std::string_view structure : kStructures) {
        const std::string name = fmt::format("waiting/{}/{}/{}", scene, ray_kind_name(kind), structure);
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
          measure_waiting(state, scene, kind, structure);
        })->UseManualTime();
      }
    }
  }
}

}  // namespace stbvh::harness
