#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "harness/microbenchmarks/benchmarks.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/procedural/shared/mesh_tools.h"
#include "harness/structures/structure_under_test.h"
#include "stbvh/structure.h"

namespace stbvh::harness {
namespace {

/// So many that branches are not learnt by heart; 192 KB, read in order.
constexpr std::size_t kRays = 4096;

/// An ellipsoid that turns: 2 * around * (rings - 1) triangles.
struct SmallScene {
  const char* name;
  std::size_t around, rings, steps;
};
constexpr SmallScene kScenes[] = {
    {"8_triangles_1_segment", 4, 2, 2},  // one leaf
    {"2024_triangles_1_segment", 46, 23, 2},
    {"2024_triangles_8_segments", 46, 23, 9},
};

Scene make_scene(const SmallScene& small) {
  Scene scene;
  const Shape shape = make_ellipsoid({1, 0.8, 0.6}, small.around, small.rings);
  add_mesh(scene, animate(small.name, shape, small.steps, {1, 1, 1}, [](Vec3 p, std::size_t, double time) {
             return rotate(axis_angle({0, 0, 1}, 0.5 * time), p);
           }));
  return scene;
}

std::size_t count_hits(std::span<const HitRecord> records) {
  return static_cast<std::size_t>(
      std::count_if(records.begin(), records.end(), [](const HitRecord& r) { return r.is_hit(); }));
}

/// Nodes and leaves that our kernels meet in all rays together.
TraversalCounters count_visits(const Scene& scene, std::span<const Ray> rays, bool any_hit) {
  const Mesh& mesh = scene.meshes.front();
  std::vector<VertexBufferView> steps;
  for (const VertexBuffer& step : mesh.steps) steps.push_back({.data = step.data(), .count = step.size()});
  MeshView view;
  view.indices = mesh.indices.data();
  view.triangle_count = mesh.triangle_count();
  view.steps = steps;
  const auto structure = Structure::build({&view, 1});
  TraversalCounters counters;
  for (const Ray& ray : rays) {
    Hit hit;
    any_hit ? structure->occluded_counted(ray, counters) : structure->intersect_counted(ray, hit, counters);
  }
  return counters;
}

/// Rays through a scene, with what is known of them; shared by the benchmarks of one kind of query.
struct Queries {
  Scene scene;
  std::vector<Ray> rays;
  bool any_hit;
  std::size_t hits;  ///< of Embree's robust triangles
  TraversalCounters visits;
};

std::shared_ptr<const Queries> make_queries(const SmallScene& small, bool any_hit) {
  auto queries = std::make_shared<Queries>();
  queries->scene = make_scene(small);
  const auto reference = build_structure("embree-robust", queries->scene, 1);
  queries->rays = make_rays(RayKind::kUniform, queries->scene, *reference, kRays, 1).rays;
  queries->any_hit = any_hit;
  std::vector<HitRecord> records(queries->rays.size());
  reference->intersect(queries->rays, records);
  queries->hits = count_hits(records);
  queries->visits = count_visits(queries->scene, queries->rays, any_hit);
  return queries;
}

/// Edges are hit or missed as each structure likes.
bool agree(std::size_t hits, std::size_t expected) {
  return hits + 4 >= expected && expected + 4 >= hits;
}

void register_structure(const std::string& name, const std::shared_ptr<const Queries>& queries,
                        std::string_view structure_name) {
  const std::shared_ptr<const StructureUnderTest> structure =
      build_structure(structure_name, queries->scene, 1);
  const bool is_ours = structure_name.starts_with("stbvh");
  benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    std::vector<HitRecord> records(kRays);
    while (state.KeepRunningBatch(kRays)) {
      queries->any_hit ? structure->occluded(queries->rays, records)
                       : structure->intersect(queries->rays, records);
    }
    const std::size_t hits = count_hits(records);
    if (!agree(hits, queries->hits)) report_wrong_answer(state);
    const auto per_ray = [](auto count) { return static_cast<double>(count) / static_cast<double>(kRays); };
    state.counters["hits"] = per_ray(hits);
    state.counters["bytes"] = static_cast<double>(structure->build_record().structure_bytes);
    if (!is_ours) return;
    state.counters["nodes"] = per_ray(queries->visits.nodes);
    state.counters["leaves"] = per_ray(queries->visits.leaves);
  });
}

}  // namespace

void register_whole_queries() {
  for (const SmallScene& scene : kScenes) {
    for (const bool any_hit : {false, true}) {
      const std::shared_ptr<const Queries> queries = make_queries(scene, any_hit);
      for (const char* structure : {"stbvh-direct", "stbvh", "embree"}) {
        register_structure(fmt::format("query/{}/{}/{}", scene.name, any_hit ? "any" : "closest", structure),
                           queries, structure);
      }
    }
  }
}

}  // namespace stbvh::harness
