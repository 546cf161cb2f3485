/// Is the blur right? Renderings of motion against the mean of renderings of scenes at rest.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "harness/cli/commands.h"
#include "harness/cli/make_folder.h"
#include "harness/cli/report_pictures.h"
#include "harness/cli/session.h"
#include "harness/files/output_file.h"
#include "harness/images/exr_file.h"
#include "harness/path_tracer/frozen_times.h"
#include "harness/path_tracer/render.h"

namespace stbvh::harness {
namespace {

/// Embree's own tree over triangles at rest: nothing of ours, and no motion.
constexpr std::string_view kFrozenStructure = "embree-robust";

LayeredImage reference_of(const Scene& scene, const Options& options, Progress& progress) {
  return mean_of_frozen_times(
      scene, kFrozenStructure, options.render, options.frozen_times, [&](std::size_t done) {
        progress.stage(fmt::format("{}: frozen time {} of {}", scene.name, done, options.frozen_times));
      });
}

}  // namespace

void run_truth(const Options& options) {
  make_folder(options.output);
  const auto file = [&](const char* name) { return options.output / name; };
  for (const char* name : {"frozen-times.exr", "motion.exr"}) check_writable(file(name));
  Progress progress;
  Report report;
  for_each_scene(options, progress, [&](const Scene& scene) {
    const std::string& name = options.structures.front();
    const LayeredImage reference = reference_of(scene, options, progress);
    write_exr(reference, file("frozen-times.exr"));
    const auto structure = build_structure(name, scene, options.threads);
    const std::string frozen_png = write_picture(reference, options.output, "frozen-times");
    for (std::size_t samples = 1;; samples = std::min(4 * samples, options.render.samples_per_pixel)) {
      RenderSettings settings = options.render;
      settings.samples_per_pixel = samples;
      progress.stage(fmt::format("{}: {} samples per pixel", scene.name, samples));
      const LayeredImage image = render(scene, *structure, settings).image;
      TruthResult result{.scene = scene.name,
                         .structure = name,
                         .reference_structure = std::string(kFrozenStructure),
                         .frozen_times = options.frozen_times,
                         .samples_per_pixel = samples,
                         .found = compare(image, reference),
                         .picture = "",
                         .reference_picture = frozen_png,
                         .difference_picture = ""};
      progress.clear();
      fmt::print("{:6} samples per pixel: RMSE {:.6f}, FLIP {:.6f}\n", samples, result.found.rmse,
                 result.found.flip_mean);
      std::fflush(stdout);
      const bool is_last = samples == options.render.samples_per_pixel;
      if (is_last) {
        write_exr(image, file("motion.exr"));
        result.picture = write_picture(image, options.output, "motion");
        result.difference_picture = write_difference(result.found, options.output, "motion-difference");
      }
      report.truths.push_back(result);
      if (is_last) break;
    }
  });
  write_records(options, report);
}

}  // namespace stbvh::harness
