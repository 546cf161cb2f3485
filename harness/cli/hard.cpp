#include <fmt/format.h>

#include "harness/cli/commands.h"
#include "harness/cli/family_run.h"
#include "harness/cli/pinned_threads.h"
#include "harness/cli/session.h"
#include "harness/cli/wrong_answers.h"
#include "harness/hard_cases/hard_case.h"
#include "harness/report/machine.h"
#include "harness/report/screen.h"
#include "harness/report/table.h"

namespace stbvh::harness {

void run_hard(const Options& options) {
  check_outputs(options);
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  fmt::print("{}", machine_line(this_machine(), built_commit()));
  std::string tables = hard_heading();
  std::string examples;
  for (const std::string& name : options.families) {
    const FamilyResults family =
        run_family(*find_hard_family(name), options.count, options, threads, progress);
    for (const HardResult& result : family.results) tables += hard_row(result);
    tables += family.examples;
    examples += family.examples;
    report.hards.insert(report.hards.end(), family.results.begin(), family.results.end());
  }
  progress.clear();
  tables += hard_legend();
  write_results(options, report, options.families.size(), hard_screen(report.hards) + examples, tables);
  require_right_answers(std::span<const HardResult>(report.hards));
}

}  // namespace stbvh::harness
