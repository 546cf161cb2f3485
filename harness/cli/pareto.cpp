#include "harness/cli/pareto.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "harness/cli/commands.h"
#include "harness/cli/family_run.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/script.h"
#include "harness/program/session.h"
#include "harness/report/machine.h"
#include "harness/report/table.h"
#include "plugin/files/output_file.h"

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

std::vector<std::string> pareto_families() {
  std::vector<std::string> names;
  for (const ParetoFamily& family : kFamilies) names.emplace_back(family.name);
  return names;
}

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

void run_pareto(const Options& options) {
  if (options.plot) check_writable(*options.plot);
  Progress progress;
  Report report;
  Options speed = options;
  speed.count = kDefaultBenchRays;
  speed.rays = {RayKind::kBounce, RayKind::kUniform};
  speed.build_budget_s = 0;
  for_each_scene(speed, progress, [&](const Scene& scene) { bench_scene(scene, speed, progress, report); });
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
  }
  report.paretos = pareto_points(options.structures, report.speeds, report.hards);
  fmt::print("{}\n{}", hard_legend(), pareto_table(report.paretos));
  write_records(options, report);
  if (options.plot) run_script("plot_pareto.py", {options.json->string(), options.plot->string()});
}

}  // namespace stbvh::harness
