#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "harness/cli/commands.h"
#include "harness/cli/judged_rays.h"
#include "harness/cli/wrong_answers.h"
#include "harness/program/options.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/scene_options.h"
#include "harness/program/session.h"
#include "harness/report/screen.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

struct ErrorOptions : SessionOptions, RayOptions {
  std::vector<std::string> structures;
  unsigned threads = 1;
};

void add_options(CLI::App& app, ErrorOptions& o) {
  o.count = 20'000;
  add_scene_options(app, o);
  add_structures_option(app, o.structures);
  add_json_option(app, o);
  add_tables_option(app, o);
  add_rays_option(app, o.rays);
  add_count_option(app, o.count);
  add_threads_option(app, o.threads, kPinnedThreads);
}

/// Adds the figures of one scene to `report`; returns their tables.
std::string run_scene(const Scene& scene, const ErrorOptions& options, PinnedThreads& threads,
                      Progress& progress, Report& report) {
  const std::vector<std::string> names = structures_that_fit(options.structures, scene, "");
  const std::vector<RaySet> sets = make_ray_sets(scene, options, options.seed, options.threads, progress);
  const JudgedRays judged(scene, sets, progress);
  std::vector<ErrorResult> results;
  for (const std::string& name : names) {
    progress.stage(fmt::format("{}: building {}", scene.name, name));
    const auto structure = build_within_limit(name, scene, options.threads);
    if (structure == nullptr) continue;
    const auto more = judged.judge(name, *structure, threads);
    results.insert(results.end(), more.begin(), more.end());
  }
  report.errors.insert(report.errors.end(), results.begin(), results.end());
  return scene_heading(summarize(scene)) + error_table(results) + distance_table(results) +
         difference_lines(results);
}

void run_error(const ErrorOptions& options) {
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  std::string tables;
  for_each_scene(options, progress,
                 [&](const Scene& scene) { tables += run_scene(scene, options, threads, progress, report); });
  progress.clear();
  write_results(options, report, options.scenes.size(), error_screen(report.errors), tables);
  require_right_answers(report.errors);
}

}  // namespace

Work error_command(CLI::App& app) {
  return make_work(app, run_error);
}

}  // namespace stbvh::harness
