/// What a structure answered, held against the oracle.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "harness/oracle/oracle.h"
#include "harness/rays/ray_set.h"

namespace stbvh::harness {

enum class Verdict { kAgrees, kMissed, kFalseHit, kWrongPrimitive, kTie, kWithinRounding };

/// "missed", "false hit", ...
std::string_view verdict_name(Verdict verdict);

/// A ray that the structure answered otherwise than the oracle; ties are not kept.
struct Difference {
  std::size_t ray;  ///< its index in the ray set
  Verdict verdict;
};

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

  /// |t - t*| / max(|t*|, 1e-6 diagonal / |d|) over rays that both hit, ascending; without `within_rounding`.
  std::vector<double> t_errors;

  std::vector<Difference> differences;

  /// Error below which the share `p` of t_errors lies; 0 if there are none.
  double t_error(double p) const;
};

/// Judges the hits of `rays`, in their order. `diagonal` is that of the scene's bounds.
ErrorCounts judge(const Oracle& oracle, double diagonal, const RaySet& rays,
                  std::span<const OracleAnswer> answers, std::span<const HitRecord> hits);

}  // namespace stbvh::harness
