#include "harness/hard_cases/judged_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/scenes/moving_triangle.h"

namespace stbvh::harness {
namespace {

/// Of the bounds of all valid triangles.
double diagonal_of(const Scene& scene) {
  Box3f box = Box3f::empty();
  for (const Mesh& mesh : scene.meshes) {
    for (std::size_t prim = 0; prim < mesh.triangle_count(); ++prim) {
      if (!is_valid_triangle(mesh, prim)) continue;
      for (const VertexBuffer& step : mesh.steps) {
        for (std::size_t c = 0; c < 3; ++c) {
          const Vec3f p = step[mesh.indices[3 * prim + c]];
          box.lower = {std::min(box.lower.x, p.x), std::min(box.lower.y, p.y), std::min(box.lower.z, p.z)};
          box.upper = {std::max(box.upper.x, p.x), std::max(box.upper.y, p.y), std::max(box.upper.z, p.z)};
        }
      }
    }
  }
  return length(to_double(box.upper) - to_double(box.lower));
}

/// Every hit is a false one.
ErrorCounts expect_nothing(std::span<const HitRecord> hits) {
  ErrorCounts counts;
  counts.traced = hits.size();
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].is_hit()) counts.differences.push_back({i, Verdict::kFalseHit});
  }
  counts.false_hits = counts.differences.size();
  return counts;
}

/// A hit at t = NaN becomes one of a triangle that does not exist, infinitely far away: a false one.
std::vector<HitRecord> with_numbers(std::span<const HitRecord> hits) {
  constexpr std::uint32_t kNoTriangle = kInvalidId - 1;
  std::vector<HitRecord> numbers(hits.begin(), hits.end());
  for (HitRecord& hit : numbers) {
    if (hit.is_hit() && std::isnan(hit.t))
      hit = {std::numeric_limits<float>::infinity(), kNoTriangle, kNoTriangle};
  }
  return numbers;
}

void add(const ErrorCounts& batch, ErrorCounts& sum) {
  sum.traced += batch.traced;
  sum.missed += batch.missed;
  sum.false_hits += batch.false_hits;
  sum.wrong_primitive += batch.wrong_primitive;
  sum.ties += batch.ties;
  sum.within_rounding += batch.within_rounding;
  sum.oracle_hits += batch.oracle_hits;
  sum.near_edge += batch.near_edge;
  sum.distances.add(batch.distances);
}

std::string describe(const Ray& r, const char* query, std::string_view what, const HitRecord& hit) {
  const std::string answer =
      hit.is_hit() ? fmt::format("triangle {} of mesh {} at t = {:.9g}", hit.prim_id, hit.geom_id, hit.t)
                   : "nothing";
  return fmt::format(
      "{} {}: from ({:.9g} {:.9g} {:.9g}) along ({:.9g} {:.9g} {:.9g}) in ({:.9g}, {:.9g}] at time {:.9g} "
      "it says {}",
      query, what, r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z, r.tnear,
      r.tfar, r.time, answer);
}

bool is_wrong(const Difference& difference) {
  return difference.verdict != Verdict::kWithinRounding;
}

}  // namespace

JudgedCase::JudgedCase(const HardCase& hard) : hard_(hard), diagonal_(diagonal_of(hard.scene)) {
  const bool asks_oracle = hard.expected == Expected::kOracle || hard.expected == Expected::kClosed;
  if (asks_oracle) oracle_.emplace(hard.scene);
  for (std::size_t first = 0; first < hard.rays.size(); first += kHardBatch) {
    const auto begin = hard.rays.begin() + static_cast<std::ptrdiff_t>(first);
    const auto size = static_cast<std::ptrdiff_t>(std::min(kHardBatch, hard.rays.size() - first));
    Batch& batch = batches_.emplace_back();
    batch.first = first;
    batch.closest = {RayKind::kUniform, std::vector<Ray>(begin, begin + size)};
    batch.any = {RayKind::kUniformOccluded, batch.closest.rays};
    if (asks_oracle) batch.answers = oracle_->answers(batch.closest.rays);
  }
}

ErrorCounts JudgedCase::judge_rays(const RaySet& rays, const Batch& batch,
                                   std::span<const HitRecord> hits) const {
  if (!oracle_) return expect_nothing(hits);
  return judge(*oracle_, diagonal_, rays, batch.answers, hits);
}

void JudgedCase::judge_batch(std::size_t index, std::span<const HitRecord> closest,
                             std::span<const HitRecord> any, HardCounts& counts) const {
  const Batch& batch = batches_[index];
  const auto note = [&](const char* query, std::string_view what, std::size_t ray, const HitRecord& hit) {
    if (counts.example.empty()) counts.example = describe(batch.closest.rays[ray], query, what, hit);
  };
  const ErrorCounts errors = judge_rays(batch.closest, batch, with_numbers(closest));
  const ErrorCounts any_errors = judge_rays(batch.any, batch, any);
  for (const Difference& d : errors.differences) {
    if (!is_wrong(d) && !closest[d.ray].is_hit()) ++counts.near_misses;
    if (is_wrong(d)) note("closest hit", verdict_name(d.verdict), d.ray, closest[d.ray]);
  }
  for (const Difference& d : any_errors.differences) {
    if (is_wrong(d)) note("any hit", verdict_name(d.verdict), d.ray, any[d.ray]);
  }
  for (std::size_t i = 0; i < closest.size(); ++i) {
    if (hard_.expected == Expected::kClosed && (!closest[i].is_hit() || !any[i].is_hit())) {
      ++counts.leaks;
      note(closest[i].is_hit() ? "any hit" : "closest hit", "leak", i,
           closest[i].is_hit() ? any[i] : closest[i]);
    }
    if (hard_.leaving.empty()) continue;
    const TriangleId from = hard_.leaving[batch.first + i];
    ++counts.departures;
    if (closest[i].geom_id == from.geom_id && closest[i].prim_id == from.prim_id) ++counts.self_hits;
    if (!batch.answers.empty() && batch.answers[i].meets({from.geom_id, from.prim_id}))
      ++counts.exact_self_hits;
  }
  add(errors, counts.errors);
  counts.any_wrong += any_errors.missed + any_errors.false_hits;
}

void JudgedCase::judge_refusal(std::string_view error, HardCounts& counts) const {
  counts.errors.traced += hard_.rays.size();
  if (!error.empty()) return;
  counts.errors.false_hits += hard_.rays.size();
  if (counts.example.empty()) {
    counts.example =
        fmt::format("{} steps are built without an error", hard_.scene.meshes.front().steps.size());
  }
}

void finish(HardCounts& counts) {
  counts.errors.distances.sort();
}

}  // namespace stbvh::harness
