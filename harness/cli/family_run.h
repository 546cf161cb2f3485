/// Tracing one family of hard cases with all structures, and judging the answers.
#pragma once

#include <string>
#include <vector>

#include "harness/cli/options.h"
#include "harness/hard_cases/hard_case.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/progress.h"
#include "harness/report/records.h"

namespace stbvh::harness {

struct FamilyResults {
  std::vector<HardResult> results;  ///< of each structure that can be asked
  std::string examples;  ///< a wrong answer of each structure that promises exact ones, a line each
};

/// `count` rays of `family` by `seed`, traced by the structures of `options`.
FamilyResults run_family(const HardFamily& family, std::size_t count, const Options& options,
                         PinnedThreads& threads, Progress& progress);

}  // namespace stbvh::harness
