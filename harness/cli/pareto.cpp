#include "harness/cli/pareto.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <optional>

#include "harness/cli/commands.h"
#include "harness/cli/family_run.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/options.h"
#include "harness/program/scene_options.h"
#include "harness/program/script.h"
#include "harness/program/session.h"
#include "harness/program/usage_error.h"
#include "harness/report/read_records.h"
#include "harness/report/table.h"
#include "harness/structures/structure_under_test.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

/// What is compared where --structures does not say: each structure in each precision.
constexpr std::array<std::string_view, 9> kStructures{"embree",     "embree-robust", "embree-4v",
                                                      "lbvh",       "lbvh-4v",       "stbvh",
                                                      "stbvh-fast", "stbvh-direct",  "stbvh-direct-fast"};

struct ParetoOptions : SessionOptions {
  std::vector<std::string> structures;
  unsigned threads = 1;
  std::size_t count = 100'000;  ///< rays of each family of hard cases
  std::size_t repeats = 7;
  std::vector<std::string> record_files;      ///< not empty: nothing is measured
  std::optional<std::filesystem::path> plot;  ///< made from the records
};

void add_options(CLI::App& app, ParetoOptions& o) {
  add_scene_options(app, o);
  add_structures_option(app, o.structures, kStructures);
  add_json_option(app, o);
  add_tables_option(app, o);
  add_threads_option(app, o.threads, kPinnedThreads);
  add_count_option(app, o.count, "Rays of each family of hard cases");
  add_repeats_option(app, o.repeats);
  app.add_option(
         "--from", o.record_files,
         "Files of bench and hard with speeds and hard cases, separated by commas: nothing is measured")
      ->delimiter(',');
  app.add_option_function<std::string>(
      "--plot", [&o](const std::string& file) { o.plot = file; },
      "PNG file for the plot; needs --json and python3-matplotlib");
}

/// What a family of hard cases says of a structure.
enum class Measure { kLeaks, kThin, kDistance };

struct ParetoFamily {
  std::string_view name;
  Measure measure;
};

constexpr ParetoFamily kFamilies[] = {
    {"closed-2k-1", Measure::kLeaks},  {"closed-2k-2", Measure::kLeaks},   {"closed-2k-8", Measure::kLeaks},
    {"closed-2k-16", Measure::kLeaks}, {"closed-2k-128", Measure::kLeaks}, {"needles-1e4", Measure::kThin},
    {"needles-1e5", Measure::kThin},   {"needles-1e6", Measure::kThin},    {"slivers-1e4", Measure::kThin},
    {"slivers-1e5", Measure::kThin},   {"slivers-1e6", Measure::kThin},    {"offset-1e6", Measure::kDistance},
};

void add_hard(const HardResult& r, ParetoResult& point) {
  const auto family = std::find_if(std::begin(kFamilies), std::end(kFamilies),
                                   [&](const ParetoFamily& f) { return f.name == r.family; });
  if (family == std::end(kFamilies)) return;
  switch (family->measure) {
    case Measure::kLeaks:
      point.aimed += r.traced;
      point.leaks += r.leaks.value_or(0);
      break;
    case Measure::kThin:
      point.thin += r.traced;
      point.differing += r.missed + r.false_hits + r.wrong_primitive + r.within_rounding;
      break;
    case Measure::kDistance:
      point.t_error_rel_p99 = r.distance.relative.p99;
      break;
  }
}

/// Geometric mean, least and largest of a structure's ratios over incoherent rays with the most threads.
Spread speed_ratio(std::span<const SpeedResult> speeds, const std::string& structure) {
  unsigned threads = 0;
  for (const SpeedResult& r : speeds) threads = std::max(threads, r.threads);
  std::vector<double> ratios;
  for (const SpeedResult& r : speeds) {
    const std::optional<Spread> ratio = r.ratio_to_embree();
    const bool is_meant =
        r.structure == structure && r.threads == threads &&
        (r.rays == ray_kind_name(RayKind::kBounce) || r.rays == ray_kind_name(RayKind::kUniform));
    if (is_meant && ratio) ratios.push_back(ratio->median);
  }
  if (ratios.empty()) return {};
  const auto [least, largest] = std::minmax_element(ratios.begin(), ratios.end());
  return {geometric_mean(ratios), *least, *largest};
}

}  // namespace

std::vector<ParetoResult> pareto_points(std::span<const std::string> structures,
                                        std::span<const SpeedResult> speeds,
                                        std::span<const HardResult> hards) {
  std::vector<ParetoResult> points;
  for (const std::string& name : structures) {
    ParetoResult point{.structure = name, .ratio_to_embree = speed_ratio(speeds, name)};
    for (const HardResult& r : hards) {
      if (r.structure == name) add_hard(r, point);
    }
    points.push_back(point);
  }
  return points;
}

namespace {

/// Speeds and hard cases of `options`; returns their tables.
std::string measure(const ParetoOptions& options, Report& report) {
  Progress progress;
  BenchOptions speed;
  static_cast<SessionOptions&>(speed) = options;
  speed.structures = options.structures;
  speed.rays = {RayKind::kBounce, RayKind::kUniform};
  speed.count = kDefaultBenchRays;
  speed.thread_counts = {options.threads};
  speed.repeats = options.repeats;
  speed.build_budget_s = 0;
  std::string tables;
  for_each_scene(speed, progress,
                 [&](const Scene& scene) { tables += bench_scene(scene, speed, progress, report); });
  tables += fmt::format("\n{}", hard_heading());
  PinnedThreads threads(options.threads);
  for (const ParetoFamily& asked : kFamilies) {
    const FamilyResults family = run_family(*find_hard_family(asked.name), options.count, options.seed,
                                            options.structures, threads, progress);
    for (const HardResult& result : family.results) tables += hard_row(result);
    report.hards.insert(report.hards.end(), family.results.begin(), family.results.end());
  }
  return tables + hard_legend() + "\n";
}

/// Speeds of all files are of machines of one type; hard cases have the same answers on all.
Report read_all(const std::vector<std::string>& files) {
  Report all;
  std::string first_file, first_machine;
  for (const std::string& file : files) {
    const ReadReport read = read_speeds_and_hards(file);
    if (all.speeds.empty() && !read.speeds.empty()) {
      first_file = file;
      first_machine = read.machine;
    }
    if (!read.speeds.empty() && read.machine != first_machine) {
      throw UsageError(
          fmt::format("--from: \"{}\" and \"{}\" were measured on machines of two types: {}; {}.", first_file,
                      file, first_machine, read.machine));
    }
    all.speeds.insert(all.speeds.end(), read.speeds.begin(), read.speeds.end());
    all.hards.insert(all.hards.end(), read.hards.begin(), read.hards.end());
  }
  return all;
}

/// Of `asked`, or of all structures where that is what is measured by default, those that there are speeds
/// and hard cases of.
std::vector<std::string> those_in(const Report& report, const std::vector<std::string>& asked) {
  const bool is_default = std::equal(asked.begin(), asked.end(), kStructures.begin(), kStructures.end());
  std::vector<std::string> found;
  for (const std::string& name : chosen_structures(is_default ? std::vector<std::string>{} : asked)) {
    const auto has = [&](const auto& r) { return r.structure == name; };
    if (std::any_of(report.speeds.begin(), report.speeds.end(), has) &&
        std::any_of(report.hards.begin(), report.hards.end(), has))
      found.push_back(name);
  }
  return found;
}

void run_pareto(const ParetoOptions& options) {
  if (options.plot) {
    if (!options.json) throw UsageError("--plot needs --json: the plot is made from the records.");
    check_writable(*options.plot);
  }
  Report report;
  std::string tables;
  if (options.record_files.empty()) {
    tables = measure(options, report);
    report.paretos = pareto_points(options.structures, report.speeds, report.hards);
  } else {
    const Report read = read_all(options.record_files);
    report.paretos = pareto_points(those_in(read, options.structures), read.speeds, read.hards);
    if (report.paretos.empty())
      throw UsageError("--from: no structure has both speeds and hard cases in these files.");
  }
  const std::string points = pareto_table(report.paretos);
  write_results(options, report, std::size(kFamilies), points, tables + points);
  if (options.plot) run_script("plot_pareto.py", {options.json->string(), options.plot->string()});
}

}  // namespace

Work pareto_command(CLI::App& app) {
  return make_work(app, run_pareto);
}

}  // namespace stbvh::harness
