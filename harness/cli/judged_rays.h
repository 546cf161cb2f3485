/// Rays that the exact oracle has answered, and what structures answer to them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "harness/oracle/oracle.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/progress.h"
#include "harness/rays/ray_set.h"
#include "harness/report/records.h"
#include "harness/scenes/scene.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

class JudgedRays {
 public:
  /// Asks the oracle about `sets`. It and `scene` must outlive this.
  JudgedRays(const Scene& scene, std::span<const RaySet> sets, Progress& progress);

  /// Traces each set once with `structure`, called `name`: a result for each, with the first of its
  /// rays that are answered otherwise.
  std::vector<ErrorResult> judge(const std::string& name, const StructureUnderTest& structure,
                                 PinnedThreads& threads) const;

 private:
  const Scene& scene_;
  std::span<const RaySet> sets_;
  Oracle oracle_;
  std::vector<std::vector<OracleAnswer>> answers_;  ///< of each set
};

}  // namespace stbvh::harness
