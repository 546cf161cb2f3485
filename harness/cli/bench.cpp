#include "harness/cli/commands.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/session.h"
#include "harness/report/screen.h"
#include "harness/report/summary.h"
#include "harness/report/table.h"

namespace stbvh::harness {

void run_bench(const BenchOptions& options) {
  Progress progress;
  Report report;
  std::string tables;
  for_each_scene(options, progress,
                 [&](const Scene& scene) { tables += bench_scene(scene, options, progress, report); });
  progress.clear();
  report.summaries = summarize_scenes(report);
  tables += summary_table(report.summaries);
  write_results(options, report, options.scenes.size(), summary_screen(report.summaries), tables);
}

}  // namespace stbvh::harness
