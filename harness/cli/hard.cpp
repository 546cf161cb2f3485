#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <string_view>

#include "harness/cli/commands.h"
#include "harness/cli/family_run.h"
#include "harness/cli/wrong_answers.h"
#include "harness/hard_cases/hard_case.h"
#include "harness/program/options.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/session.h"
#include "harness/program/whole_numbers.h"
#include "harness/report/machine.h"
#include "harness/report/screen.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

/// What is compared where --structures does not say: ours in every layout and instruction set, Embree's in
/// every precision.
constexpr std::array<std::string_view, 7> kStructures{
    "stbvh-direct", "stbvh-direct-indexed", "stbvh-direct-scalar", "stbvh", "embree", "embree-robust",
    "embree-4v"};

struct HardOptions : RecordOptions {
  std::vector<std::string> structures;
  unsigned threads = 1;
  std::vector<std::string> families;  ///< in the order of hard_families()
  std::size_t count = 20'000;         ///< rays of each
  std::uint64_t seed = 1;
};

void add_options(CLI::App& app, HardOptions& o) {
  add_structures_option(app, o.structures, kStructures);
  add_json_option(app, o);
  add_tables_option(app, o);
  add_threads_option(app, o.threads, kPinnedThreads);
  const auto choose = [&o](const std::vector<std::string>& asked) {
    std::vector<std::string_view> known;
    for (const HardFamily& family : hard_families()) known.push_back(family.name);
    o.families = chosen_names("family", asked, known);
  };
  choose({});
  app.add_option_function<std::vector<std::string>>(
         "--families", choose, "Families of hard cases (see list), or all; separated by commas")
      ->delimiter(',')
      ->default_str("all");
  add_count_option(app, o.count, "Rays of each family");
  add_seed_option(app, o.seed, "Seed of scenes and rays");
}

void run_hard(const HardOptions& options) {
  check_outputs(options);
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  fmt::print("{}", machine_line(this_machine(), built_commit()));
  std::string tables = hard_heading();
  std::string examples;
  for (const std::string& name : options.families) {
    const FamilyResults family = run_family(*find_hard_family(name), options.count, options.seed,
                                            options.structures, threads, progress);
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

}  // namespace

Work hard_command(CLI::App& app) {
  return make_work(app, run_hard);
}

}  // namespace stbvh::harness
