#include "harness/cli/judged_rays.h"

#include <fmt/format.h>

#include <algorithm>

#include "harness/cli/distance_figures.h"
#include "harness/oracle/judge.h"
#include "harness/program/trace.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kPrintedDifferences = 3;  // for each structure and kind of rays

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
std::string describe(const Scene& scene, const std::string& structure, const RaySet& rays,
                     const OracleAnswer& exact, const Difference& difference, const HitRecord& hit) {
  const Ray& r = rays.rays[difference.ray];
  const bool any = rays.any_hit();
  return fmt::format(
      "  {}, {} {}, {}: from ({:.9g} {:.9g} {:.9g}) along ({:.9g} {:.9g} {:.9g}) at time {:.9g}: it says {}, "
      "the oracle {}; an edge is {:.2g} ulps away\n",
      structure, ray_kind_name(rays.kind), difference.ray, verdict_name(difference.verdict), r.origin.x,
      r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z, r.time,
      describe_hit(scene, hit.is_hit(), any, hit.t, hit.geom_id, hit.prim_id),
      describe_hit(scene, exact.is_hit, any, exact.t, exact.geom_id, exact.prim_id),
      exact.edge_distance_ulps);
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
                                           PinnedThreads& threads, std::string& differences) const {
  std::vector<ErrorResult> results;
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    std::vector<HitRecord> hits(sets_[s].rays.size());
    trace(threads, structure, sets_[s], hits);
    const ErrorCounts counts =
        harness::judge(oracle_, diagonal(scene_.bounds()), sets_[s], answers_[s], hits);
    results.push_back(to_result(scene_, name, sets_[s], counts));
    for (std::size_t i = 0; i < std::min(counts.differences.size(), kPrintedDifferences); ++i) {
      const Difference& d = counts.differences[i];
      differences += describe(scene_, name, sets_[s], answers_[s][d.ray], d, hits[d.ray]);
    }
  }
  return results;
}

}  // namespace stbvh::harness
