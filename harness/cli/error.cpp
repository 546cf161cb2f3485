#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "harness/cli/commands.h"
#include "harness/cli/distance_figures.h"
#include "harness/cli/wrong_answers.h"
#include "harness/oracle/judge.h"
#include "harness/program/options.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/scene_options.h"
#include "harness/program/session.h"
#include "harness/program/trace.h"
#include "harness/report/screen.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kPrintedDifferences = 3;  // for each structure and kind of rays

struct ErrorOptions : SessionOptions, RayOptions {
  std::vector<std::string> structures;
  unsigned threads = 1;
};

void add_options(CLI::App& app, ErrorOptions& o) {
  o.count = 20'000;
  add_scene_options(app, o);
  add_structures_option(app, o.structures);
  add_json_option(app, o);
  add_tables_option(app, o);
  add_rays_option(app, o.rays);
  add_count_option(app, o.count);
  add_threads_option(app, o.threads, kPinnedThreads);
}

/// A ray set and what the oracle says of it.
struct JudgedRays {
  RaySet rays;
  std::vector<OracleAnswer> answers;
};

ErrorResult to_result(const Scene& scene, const std::string& structure, const RaySet& rays,
                      const ErrorCounts& counts) {
  return {.scene = scene.name,
          .structure = structure,
          .rays = std::string(ray_kind_name(rays.kind)),
          .traced = counts.traced,
          .oracle_hits = counts.oracle_hits,
          .missed = counts.missed,
          .false_hits = counts.false_hits,
          .wrong_primitive = counts.wrong_primitive,
          .ties = counts.ties,
          .within_rounding = counts.within_rounding,
          .near_edge = counts.near_edge,
          .distance = distance_figures(counts.distances),
          .is_any_hit = rays.any_hit()};
}

std::string describe_hit(const Scene& scene, bool is_hit, bool is_any_hit, double t, std::uint32_t mesh,
                         std::uint32_t triangle) {
  if (!is_hit) return "nothing";
  if (is_any_hit) return "something";
  const bool has_faces = mesh < scene.meshes.size() && !scene.meshes[mesh].faces.empty();
  return fmt::format("triangle {}{} of mesh {} at t = {:.9g}", triangle,
                     has_faces ? fmt::format(" (face {})", scene.meshes[mesh].face_of(triangle)) : "", mesh,
                     t);
}

/// A ray that a structure and the oracle answer differently, so that it can be traced again.
std::string describe(const Scene& scene, const std::string& structure, const JudgedRays& set,
                     const Difference& difference, const HitRecord& hit) {
  const Ray& r = set.rays.rays[difference.ray];
  const OracleAnswer& exact = set.answers[difference.ray];
  const bool any = set.rays.any_hit();
  return fmt::format(
      "  {}, {} {}, {}: from ({:.9g} {:.9g} {:.9g}) along ({:.9g} {:.9g} {:.9g}) at time {:.9g}: it says {}, "
      "the oracle {}; an edge is {:.2g} ulps away\n",
      structure, ray_kind_name(set.rays.kind), difference.ray, verdict_name(difference.verdict), r.origin.x,
      r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z, r.time,
      describe_hit(scene, hit.is_hit(), any, hit.t, hit.geom_id, hit.prim_id),
      describe_hit(scene, exact.is_hit, any, exact.t, exact.geom_id, exact.prim_id),
      exact.edge_distance_ulps);
}

/// Adds the figures of one scene to `report`; returns their tables.
std::string run_scene(const Scene& scene, const ErrorOptions& options, PinnedThreads& threads,
                      Progress& progress, Report& report) {
  const std::vector<std::string> names = structures_that_fit(options.structures, scene, "");
  std::vector<JudgedRays> sets;
  for (RaySet& rays : make_ray_sets(scene, options, options.seed, options.threads, progress))
    sets.push_back({std::move(rays), {}});
  progress.stage(fmt::format("{}: building the oracle", scene.name));
  const Oracle oracle(scene);
  for (JudgedRays& set : sets) {
    progress.stage(fmt::format("{}: asking the oracle, {}", scene.name, ray_kind_name(set.rays.kind)));
    set.answers = oracle.answers(set.rays.rays);
  }
  std::vector<ErrorResult> results;
  std::string differences;
  for (const std::string& name : names) {
    progress.stage(fmt::format("{}: building {}", scene.name, name));
    const auto structure = build_within_limit(name, scene, options.threads);
    if (structure == nullptr) continue;
    for (const JudgedRays& set : sets) {
      std::vector<HitRecord> hits(set.rays.rays.size());
      trace(threads, *structure, set.rays, hits);
      const ErrorCounts counts = judge(oracle, diagonal(scene.bounds()), set.rays, set.answers, hits);
      results.push_back(to_result(scene, name, set.rays, counts));
      for (std::size_t i = 0; i < std::min(counts.differences.size(), kPrintedDifferences); ++i) {
        const Difference& d = counts.differences[i];
        differences += describe(scene, name, set, d, hits[d.ray]);
      }
    }
  }
  report.errors.insert(report.errors.end(), results.begin(), results.end());
  return scene_heading(summarize(scene)) + error_table(results) + distance_table(results) + differences;
}

void run_error(const ErrorOptions& options) {
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  std::string tables;
  for_each_scene(options, progress,
                 [&](const Scene& scene) { tables += run_scene(scene, options, threads, progress, report); });
  progress.clear();
  write_results(options, report, options.scenes.size(), error_screen(report.errors), tables);
  require_right_answers(report.errors);
}

}  // namespace

Work error_command(CLI::App& app) {
  return make_work(app, run_error);
}

}  // namespace stbvh::harness
