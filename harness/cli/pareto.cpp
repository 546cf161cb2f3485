/// Speed against error: one point for each structure.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "harness/cli/commands.h"
#include "harness/cli/family_run.h"
#include "harness/cli/scene_bench.h"
#include "harness/cli/script.h"
#include "harness/cli/session.h"
#include "harness/files/output_file.h"
#include "harness/report/machine.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

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

void add_family(const FamilyResults& family, Measure measure, std::vector<ParetoResult>& points) {
  for (const HardResult& r : family.results) {
    const auto point = std::find_if(points.begin(), points.end(),
                                    [&](const ParetoResult& p) { return p.structure == r.structure; });
    switch (measure) {
      case Measure::kLeaks:
        point->aimed += r.traced;
        point->leaks += r.leaks.value_or(0);
        break;
      case Measure::kThin:
        point->thin += r.traced;
        point->differing += r.missed + r.false_hits + r.wrong_primitive + r.within_rounding;
        break;
      case Measure::kDistance:
        point->t_error_rel_p99 = r.t_error_rel_p99;
        break;
    }
  }
}

/// Geometric mean, least and largest of the ratios that the report has of a structure.
Spread speed_ratio(const Report& report, const std::string& structure) {
  std::vector<double> ratios;
  for (const SpeedResult& r : report.speeds) {
    const std::optional<Spread> ratio = r.ratio_to_embree();
    if (r.structure == structure && ratio) ratios.push_back(ratio->median);
  }
  if (ratios.empty()) return {};
  const auto [least, largest] = std::minmax_element(ratios.begin(), ratios.end());
  return {geometric_mean(ratios), *least, *largest};
}

}  // namespace

void run_pareto(const Options& options) {
  if (options.plot) check_writable(*options.plot);
  Progress progress;
  Report report;
  Options speed = options;
  speed.count = kDefaultBenchRays;
  speed.rays = {RayKind::kBounce, RayKind::kUniform};
  speed.build_budget_s = 0;
  for_each_scene(speed, progress, [&](const Scene& scene) { bench_scene(scene, speed, progress, report); });
  for (const std::string& name : options.structures) {
    report.paretos.push_back({.structure = name, .ratio_to_embree = speed_ratio(report, name)});
  }
  progress.clear();
  fmt::print("\n{}", hard_heading());
  PinnedThreads threads(options.threads);
  for (const ParetoFamily& asked : kFamilies) {
    const FamilyResults family =
        run_family(*find_hard_family(asked.name), options.count, options, threads, progress);
    progress.clear();
    for (const HardResult& result : family.results) fmt::print("{}", hard_row(result));
    std::fflush(stdout);
    report.hards.insert(report.hards.end(), family.results.begin(), family.results.end());
    add_family(family, asked.measure, report.paretos);
  }
  fmt::print("{}\n{}", hard_legend(), pareto_table(report.paretos));
  write_records(options, report);
  if (options.plot) run_script("plot_pareto.py", {options.json->string(), options.plot->string()});
}

}  // namespace stbvh::harness
