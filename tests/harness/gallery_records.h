/// What `stbvh-ab gallery` would have found, made up.
#pragma once

#include <string>

#include "harness/report/records.h"
#include "harness/report/summary.h"

namespace stbvh::harness {

/// Two scenes; a method that is exact, one that answers for other times, one without vector instructions that
/// does not take the second scene, one of ours without an idea.
inline Report gallery_report() {
  constexpr std::string_view kReferences[]{"stbvh-direct", "stbvh-direct-scalar"};
  constexpr const char* kNames[]{"union",        "separate-2",         "kd4", "no-meshlets", "embree",
                                 "stbvh-direct", "stbvh-direct-scalar"};
  Report report;
  for (const std::string scene : {"a", "b"}) {
    double speed = 0.75;
    for (const std::string name : kNames) {
      speed += 0.25;
      const bool is_scalar = name == "kd4" || name == "stbvh-direct-scalar";
      GalleryResult result{.scene = scene,
                           .structure = name,
                           .compared_with = std::string(kReferences[is_scalar ? 1 : 0]),
                           .is_exact = name != "separate-2" && name != "embree",
                           .steps = name == "kd4" ? "17" : "any"};
      if (name == "kd4" && scene == "b") {
        result.obstacle = "it has too many steps";
        report.galleries.push_back(result);
        continue;
      }
      if (name != "embree") result.visits = {10 * speed, 2 * speed, 9 * speed};
      result.traced = 1000;
      result.wrong = result.is_exact ? 0 : 25;
      report.galleries.push_back(result);
      report.builds.push_back({.scene = scene,
                               .structure = name,
                               .triangles = 10,
                               .threads = 1,
                               .builds = 1,
                               .build_s = {speed, speed, speed},
                               .peak_bytes = 300,
                               .structure_bytes = 200,
                               .total_bytes = 250});
      for (const char* rays : {"bounce", "uniform", "shadow"}) {
        report.speeds.push_back({.scene = scene,
                                 .structure = name,
                                 .rays = rays,
                                 .ray_count = 10,
                                 .threads = 1,
                                 .repeats = 2,
                                 .mrays_per_s = {speed, speed, speed},
                                 .ratios_to_embree = {speed, 1.5 * speed}});
      }
      for (const char* over : {"steps", "quarter turns"}) {
        for (std::size_t value : {2u, 4u}) {
          if (scene == "b") continue;
          report.scalings.push_back({.over = over,
                                     .value = value,
                                     .build = report.builds.back(),
                                     .speeds = {report.speeds.back()}});
        }
      }
    }
  }
  for (const std::string name : {"", "union", "no-meshlets", "stbvh-direct"}) {
    for (double time : {0.25, 0.75}) {
      report.slices.push_back(
          {.scene = "turning-bar",
           .structure = name,
           .time = time,
           .shapes = {{{0, 0}, {1, 0}, {0, 1}}, {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5f, 0.5f}}}});
    }
  }
  report.summaries = summarize_scenes(report, kReferences);
  return report;
}

}  // namespace stbvh::harness
