#include <fmt/format.h>

#include <cstdio>

#include "harness/cli/commands.h"
#include "harness/cli/family_run.h"
#include "harness/cli/wrong_answers.h"
#include "harness/hard_cases/hard_case.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/session.h"
#include "harness/report/machine.h"
#include "harness/report/table.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {

void run_hard(const Options& options) {
  if (options.json) check_writable(*options.json);
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  fmt::print("{}{}", machine_line(this_machine(), built_commit()), hard_heading());
  for (const std::string& name : options.families) {
    const FamilyResults family =
        run_family(*find_hard_family(name), options.count, options, threads, progress);
    progress.clear();
    for (const HardResult& result : family.results) fmt::print("{}", hard_row(result));
    fmt::print("{}", family.examples);
    std::fflush(stdout);
    report.hards.insert(report.hards.end(), family.results.begin(), family.results.end());
  }
  fmt::print("{}", hard_legend());
  write_records(options, report);
  require_right_answers(std::span<const HardResult>(report.hards));
}

}  // namespace stbvh::harness
