#include "harness/oracle/judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stbvh::harness {
namespace {

Verdict judge_miss(const OracleAnswer& answer) {
  if (!answer.is_hit) return Verdict::kAgrees;
  return answer.is_certain() ? Verdict::kMissed : Verdict::kWithinRounding;
}

Verdict judge_occlusion(const OracleAnswer& answer, const HitRecord& hit) {
  if (!hit.is_hit()) return judge_miss(answer);
  if (answer.is_hit) return Verdict::kAgrees;
  return answer.is_possible ? Verdict::kWithinRounding : Verdict::kFalseHit;
}

Verdict judge_hit(const Oracle& oracle, const Ray& ray, const OracleAnswer& answer, const HitRecord& hit) {
  if (!hit.is_hit()) return judge_miss(answer);
  const OraclePrimitive reported{hit.geom_id, hit.prim_id};
  if (answer.meets(reported)) return Verdict::kAgrees;
  const auto test = oracle.test(ray, hit.geom_id, hit.prim_id);
  if (!test || !test->is_possible) return Verdict::kFalseHit;
  if (test->t_lower > answer.certain_t_upper) return Verdict::kWrongPrimitive;
  const bool same_t = answer.is_hit && test->t_lower <= answer.t_upper && test->t_upper >= answer.t_lower;
  return same_t ? Verdict::kTie : Verdict::kWithinRounding;
}

/// The distance between floats of the magnitude of `x`.
double float_spacing(double x) {
  constexpr int kDigits = std::numeric_limits<float>::digits;
  constexpr int kLeastExponent = std::numeric_limits<float>::min_exponent;
  int exponent = kLeastExponent;
  if (x != 0) std::frexp(x, &exponent);
  return std::ldexp(1.0, std::max(exponent, kLeastExponent) - kDigits);
}

void note_distance(const Ray& ray, const OracleAnswer& answer, float t, double diagonal,
                   DistanceErrors& errors) {
  const double speed = length(to_double(ray.direction));
  const double error = std::abs(static_cast<double>(t) - answer.t);
  errors.relative.push_back(error / std::max(std::abs(answer.t), 1e-6 * diagonal / speed));
  errors.ulps.push_back(error / float_spacing(answer.t));
  if (answer.cosine < kGrazingCosine) errors.off_plane.push_back(error * speed * answer.cosine);
}

void count(Verdict verdict, ErrorCounts& counts) {
  switch (verdict) {
    case Verdict::kAgrees:
      break;
    case Verdict::kMissed:
      ++counts.missed;
      break;
    case Verdict::kFalseHit:
      ++counts.false_hits;
      break;
    case Verdict::kWrongPrimitive:
      ++counts.wrong_primitive;
      break;
    case Verdict::kTie:
      ++counts.ties;
      break;
    case Verdict::kWithinRounding:
      ++counts.within_rounding;
      break;
  }
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAgrees:
      break;
    case Verdict::kMissed:
      return "missed";
    case Verdict::kFalseHit:
      return "false hit";
    case Verdict::kWrongPrimitive:
      return "wrong primitive";
    case Verdict::kTie:
      return "tie";
    case Verdict::kWithinRounding:
      return "within rounding";
  }
  return "agrees";
}

void DistanceErrors::add(const DistanceErrors& other) {
  relative.insert(relative.end(), other.relative.begin(), other.relative.end());
  ulps.insert(ulps.end(), other.ulps.begin(), other.ulps.end());
  off_plane.insert(off_plane.end(), other.off_plane.begin(), other.off_plane.end());
}

void DistanceErrors::sort() {
  for (auto* values : {&relative, &ulps, &off_plane}) std::sort(values->begin(), values->end());
}

double percentile(const std::vector<double>& values, double p) {
  if (values.empty()) return 0;
  const double last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::ceil(p * last))];
}

ErrorCounts judge(const Oracle& oracle, double diagonal, const RaySet& rays,
                  std::span<const OracleAnswer> answers, std::span<const HitRecord> hits) {
  ErrorCounts counts;
  counts.traced = rays.rays.size();
  for (std::size_t i = 0; i < rays.rays.size(); ++i) {
    const Ray& ray = rays.rays[i];
    const OracleAnswer& answer = answers[i];
    counts.oracle_hits += answer.is_hit ? 1 : 0;
    counts.near_edge += answer.is_near_edge ? 1 : 0;
    const Verdict verdict =
        rays.any_hit() ? judge_occlusion(answer, hits[i]) : judge_hit(oracle, ray, answer, hits[i]);
    count(verdict, counts);
    if (verdict != Verdict::kAgrees && verdict != Verdict::kTie) counts.differences.push_back({i, verdict});
    if (rays.any_hit() || verdict == Verdict::kWithinRounding || !answer.is_hit || !hits[i].is_hit())
      continue;
    note_distance(ray, answer, hits[i].t, diagonal, counts.distances);
  }
  counts.distances.sort();
  return counts;
}

}  // namespace stbvh::harness
