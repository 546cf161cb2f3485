#include "harness/cli/judged_rays.h"

#include <fmt/format.h>

#include <algorithm>

#include "harness/cli/distance_figures.h"
#include "harness/oracle/judge.h"
#include "harness/program/trace.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kKeptDifferences = 3;  // for each structure and kind of rays

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
          .is_any_hit = rays.any_hit(),
          .has_tolerance = scene.tolerance > 0.0f};
}

RecordedAnswer to_record(const Scene& scene, bool is_hit, bool is_any_hit, double t, std::uint32_t mesh,
                         std::uint32_t triangle) {
  if (!is_hit || is_any_hit) return {.is_hit = is_hit};
  RecordedAnswer::Hit hit{.t = t, .mesh = mesh, .primitive = triangle};
  const bool has_faces = mesh < scene.meshes.size() && !scene.meshes[mesh].faces.empty();
  if (has_faces) hit.face = scene.meshes[mesh].face_of(triangle);
  return {.is_hit = true, .hit = hit};
}

DifferingRay to_record(const Scene& scene, const RaySet& rays, const OracleAnswer& exact,
                       const Difference& difference, const HitRecord& hit) {
  const Ray& r = rays.rays[difference.ray];
  const bool any = rays.any_hit();
  return {.ray = difference.ray,
          .verdict = std::string(verdict_name(difference.verdict)),
          .origin = {r.origin.x, r.origin.y, r.origin.z},
          .direction = {r.direction.x, r.direction.y, r.direction.z},
          .tnear = r.tnear,
          .tfar = r.tfar,
          .time = r.time,
          .reported = to_record(scene, hit.is_hit(), any, hit.t, hit.geom_id, hit.prim_id),
          .exact = to_record(scene, exact.is_hit, any, exact.t, exact.geom_id, exact.prim_id),
          .edge_distance_ulps = exact.edge_distance_ulps};
}

}  // namespace

JudgedRays::JudgedRays(const Scene& scene, std::span<const RaySet> sets, Progress& progress)
    : scene_(scene), sets_(sets), oracle_((progress.stage(scene.name + ": building the oracle"), scene)) {
  for (const RaySet& set : sets) {
    progress.stage(fmt::format("{}: asking the oracle, {}", scene.name, ray_kind_name(set.kind)));
    answers_.push_back(oracle_.answers(set.rays));
  }
}

std::vector<ErrorResult> JudgedRays::judge(const std::string& name, const StructureUnderTest& structure,
                                           PinnedThreads& threads) const {
  std::vector<ErrorResult> results;
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    std::vector<HitRecord> hits(sets_[s].rays.size());
    trace(threads, structure, sets_[s], hits);
    const ErrorCounts counts =
        harness::judge(oracle_, diagonal(scene_.bounds()), sets_[s], answers_[s], hits);
    ErrorResult& result = results.emplace_back(to_result(scene_, name, sets_[s], counts));
    for (std::size_t i = 0; i < std::min(counts.differences.size(), kKeptDifferences); ++i) {
      const Difference& d = counts.differences[i];
      result.differences.push_back(to_record(scene_, sets_[s], answers_[s][d.ray], d, hits[d.ray]));
    }
  }
  return results;
}

}  // namespace stbvh::harness
