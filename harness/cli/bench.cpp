#include <fmt/format.h>

#include "harness/cli/commands.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/session.h"
#include "harness/report/summary.h"
#include "harness/report/table.h"

namespace stbvh::harness {

void run_bench(const BenchOptions& options) {
  Progress progress;
  Report report;
  for_each_scene(options, progress,
                 [&](const Scene& scene) { bench_scene(scene, options, progress, report); });
  progress.clear();
  report.summaries = summarize_scenes(report);
  fmt::print("{}", summary_table(report.summaries));
  write_records(options, report);
}

}  // namespace stbvh::harness
