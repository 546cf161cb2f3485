/// Holds what structures answer to a hard case against what is expected.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/hard_cases/hard_case.h"
#include "harness/oracle/judge.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// What one structure answered to the rays of a family.
struct HardCounts {
  ErrorCounts errors;               ///< of closest hits; differences are not kept
  std::size_t leaks = 0;            ///< rays from inside a closed mesh that got out of it, by either query
  std::size_t near_misses = 0;      ///< of closest hits: exact hits that were missed, within rounding
  std::size_t any_wrong = 0;        ///< occlusion rays that missed or falsely hit
  std::size_t self_hits = 0;        ///< rays that hit the triangle which they leave from
  std::size_t exact_self_hits = 0;  ///< rays of which that is the exact answer
  std::size_t departures = 0;       ///< rays that leave from a triangle
  std::string example;              ///< the first wrong ray, empty if there is none

  bool is_right() const {
    return leaks + any_wrong + errors.missed + errors.false_hits + errors.wrong_primitive == 0;
  }
};

/// Rays are judged in batches of this many.
inline constexpr std::size_t kHardBatch = 20'000;

/// A case, the oracle over its scene, and the oracle's answers to all its rays. The case must outlive it.
class JudgedCase {
 public:
  explicit JudgedCase(const HardCase& hard);

  const Scene& scene() const { return hard_.scene; }

  std::size_t batch_count() const { return batches_.size(); }
  /// The rays of a batch, asked for their closest hits, or whether there is any.
  const RaySet& closest(std::size_t batch) const { return batches_[batch].closest; }
  const RaySet& any(std::size_t batch) const { return batches_[batch].any; }

  /// Adds to `counts` what a structure answered to both sets of a batch.
  void judge_batch(std::size_t batch, std::span<const HitRecord> closest, std::span<const HitRecord> any,
                   HardCounts& counts) const;

  bool must_be_refused() const { return hard_.expected == Expected::kRefused; }
  /// Where the scene must be refused: adds whether it was, `error` being the text, empty if it was built.
  void judge_refusal(std::string_view error, HardCounts& counts) const;

 private:
  struct Batch {
    std::size_t first;
    RaySet closest;
    RaySet any;
    std::vector<OracleAnswer> answers;
  };

  ErrorCounts judge_rays(const RaySet& rays, const Batch& batch, std::span<const HitRecord> hits) const;

  const HardCase& hard_;
  double diagonal_;
  std::optional<Oracle> oracle_;  ///< empty where it is not asked
  std::vector<Batch> batches_;
};

/// Puts distance errors in order after the last batch.
void finish(HardCounts& counts);

}  // namespace stbvh::harness
