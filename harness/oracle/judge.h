/// What a structure answered, held against the oracle.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "harness/oracle/oracle.h"
#include "harness/rays/ray_set.h"
#include "harness/structures/hit_record.h"

namespace stbvh::harness {

enum class Verdict { kAgrees, kMissed, kFalseHit, kWrongPrimitive, kTie, kWithinRounding };

/// "missed", "false hit", ...
std::string_view verdict_name(Verdict verdict);

/// A ray that the structure answered otherwise than the oracle; ties are not kept.
struct Difference {
  std::size_t ray;  ///< its index in the ray set
  Verdict verdict;
};

/// A hit is a grazing one where the cosine between ray and normal is below this (6 degrees).
inline constexpr double kGrazingCosine = 0.1;

/// How far reported distances are from the exact ones, over rays that both hit, without those that differ
/// within rounding; each list ascending.
struct DistanceErrors {
  std::vector<double> relative;   ///< |t - t*| / max(|t*|, 1e-6 diagonal / |d|)
  std::vector<double> ulps;       ///< |t - t*| in units of the spacing of floats at t*
  std::vector<double> off_plane;  ///< of grazing hits: of o + t d from the exact plane, in units of the scene

  void add(const DistanceErrors& other);
  void sort();
};

/// The value below which the share `p` of ascending `values` lies; 0 if there are none.
double percentile(const std::vector<double>& values, double p);

/// Every ray that does not agree with the exact answer is counted once, in one of the first five or, where
/// the exact answer itself changes within rounding, in `within_rounding`.
struct ErrorCounts {
  std::size_t traced = 0;
  std::size_t missed = 0;           ///< nothing reported, though something is hit however things move
  std::size_t false_hits = 0;       ///< a triangle reported that is not hit within rounding
  std::size_t wrong_primitive = 0;  ///< a triangle reported beyond one that is hit however things move
  std::size_t ties = 0;             ///< another triangle than the nearest ones, at the same t within rounding
  std::size_t within_rounding = 0;  ///< other differences at rays whose exact answer changes within rounding

  std::size_t oracle_hits = 0;  ///< rays with an exact hit
  std::size_t near_edge = 0;    ///< rays whose exact answer may change within rounding, whatever was reported

  DistanceErrors distances;

  std::vector<Difference> differences;
};

/// Judges the hits of `rays`, in their order. `diagonal` is that of the scene's bounds.
ErrorCounts judge(const Oracle& oracle, double diagonal, const RaySet& rays,
                  std::span<const OracleAnswer> answers, std::span<const HitRecord> hits);

}  // namespace stbvh::harness
