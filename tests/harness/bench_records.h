/// Records of a benchmark, made up.
#pragma once

#include "harness/report/summary.h"

namespace stbvh::harness {

/// Two scenes, three structures (one of them not in the registry), two thread counts.
inline Report bench_report() {
  Report report;
  for (const char* scene : {"a", "b"}) {
    double speed = 1;
    for (const char* structure : {"embree", "stbvh", "new-tree"}) {
      report.builds.push_back({.scene = scene,
                               .structure = structure,
                               .triangles = 10,
                               .threads = 2,
                               .builds = 1,
                               .build_s = {speed, speed, speed},
                               .peak_bytes = 300,
                               .structure_bytes = 200,
                               .total_bytes = 250});
      for (unsigned threads : {1u, 2u}) {
        report.speeds.push_back({.scene = scene,
                                 .structure = structure,
                                 .rays = "bounce",
                                 .ray_count = 10,
                                 .threads = threads,
                                 .repeats = 2,
                                 .mrays_per_s = {speed, speed, speed},
                                 .ratios_to_embree = {speed, 1.5 * speed}});
      }
      speed += 0.5;
    }
  }
  report.summaries = summarize_scenes(report);
  return report;
}

}  // namespace stbvh::harness
