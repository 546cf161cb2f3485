/// Tracing one family of hard cases with all structures, and judging the answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "harness/hard_cases/hard_case.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/progress.h"
#include "harness/report/records.h"

namespace stbvh::harness {

struct FamilyResults {
  std::vector<HardResult> results;  ///< of each structure that can be asked
  std::string examples;  ///< a wrong answer of each structure that promises exact ones, a line each
};

/// `count` rays of `family` by `seed`, traced by `structures`.
FamilyResults run_family(const HardFamily& family, std::size_t count, std::uint64_t seed,
                         const std::vector<std::string>& structures, PinnedThreads& threads,
                         Progress& progress);

}  // namespace stbvh::harness
