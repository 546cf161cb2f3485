#include <fmt/format.h>

#include "harness/cli/commands.h"
#include "harness/cli/scene_bench.h"
#include "harness/cli/session.h"
#include "harness/report/table.h"

namespace stbvh::harness {

void run_bench(const Options& options) {
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  for_each_scene(options, progress, report,
                 [&](const Scene& scene) { bench_scene(scene, options, threads, progress, report); });
  progress.clear();
  fmt::print("{}", speed_summary(report));
}

}  // namespace stbvh::harness
