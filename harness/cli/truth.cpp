/// Is the blur right? Renderings of motion against the mean of renderings of scenes at rest.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/cli/report_pictures.h"
#include "harness/images/exr_file.h"
#include "harness/path_tracer/frozen_times.h"
#include "harness/path_tracer/render.h"
#include "harness/program/interruption.h"
#include "harness/program/make_folder.h"
#include "harness/program/options.h"
#include "harness/program/session.h"
#include "harness/program/usage_error.h"
#include "harness/report/table.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostFrozenTimes = 1'000'000;
constexpr std::array<std::string_view, 1> kStructure{"stbvh"};

struct TruthOptions : SessionOptions {
  std::vector<std::string> structures;  ///< one
  std::size_t frozen_times = 1024;
  RenderSettings render;
  std::string output;  ///< folder
};

void add_options(CLI::App& app, TruthOptions& o) {
  add_scene_options(app, o);
  o.scenes = {"wheels"};
  add_structures_option(app, o.structures, kStructure, "The structure that renders the motion");
  add_number_option(app, "--frozen-times", o.frozen_times, kMostFrozenTimes,
                    "Times whose renderings, one sample for each pixel, are combined to the reference");
  add_size_option(app, o.render);
  add_samples_option(app, o.render, "Most samples for each pixel; from 1 on, times 4");
  add_threads_option(app, o.render.threads);
  app.add_option("-o,--output", o.output, "Folder for the pictures; made if it is not there")->required();
  add_json_option(app, o);
}

/// Embree's own tree over triangles at rest: nothing of ours, and no motion.
constexpr std::string_view kFrozenStructure = "embree-robust";

class TruthRun {
 public:
  TruthRun(const TruthOptions& options, const Scene& scene, Progress& progress)
      : options_(options), scene_(scene), progress_(progress) {}

  std::vector<TruthResult> results() {
    const LayeredImage reference = render_frozen_times();
    write_exr(reference, file("frozen-times.exr"));
    const std::string frozen_png = write_picture(reference, options_.output, "frozen-times");
    const std::string& name = options_.structures.front();
    const auto structure = build_structure(name, scene_, options_.render.threads);
    std::vector<TruthResult> results;
    for (std::size_t samples = 1;; samples = std::min(4 * samples, options_.render.samples_per_pixel)) {
      const LayeredImage image = render_motion(*structure, samples);
      TruthResult& result =
          results.emplace_back(TruthResult{.scene = scene_.name,
                                           .structure = name,
                                           .reference_structure = std::string(kFrozenStructure),
                                           .frozen_times = options_.frozen_times,
                                           .samples_per_pixel = samples,
                                           .found = compare(image, reference),
                                           .picture = "",
                                           .reference_picture = frozen_png,
                                           .difference_picture = ""});
      fmt::print("{:6} samples per pixel: RMSE {:.6f}, FLIP {:.6f}\n", samples, result.found.rmse,
                 result.found.flip_mean);
      std::fflush(stdout);
      if (samples < options_.render.samples_per_pixel) continue;
      write_exr(image, file("motion.exr"));
      result.picture = write_picture(image, options_.output, "motion");
      result.difference_picture = write_difference(result.found, options_.output, "motion-difference");
      return results;
    }
  }

 private:
  std::filesystem::path file(const char* name) const { return std::filesystem::path(options_.output) / name; }

  LayeredImage render_frozen_times() {
    std::size_t done = 0;
    std::optional<LayeredImage> mean = mean_of_frozen_times(
        scene_, kFrozenStructure, options_.render, options_.frozen_times,
        [&](std::size_t count) {
          done = count;
          progress_.stage(fmt::format("{}: frozen time {} of {}", scene_.name, done, options_.frozen_times));
        },
        &interruption_.flag());
    progress_.clear();
    if (!mean) {
      throw Interrupted(fmt::format("Interrupted after {} of {} frozen times: nothing is written.", done,
                                    options_.frozen_times));
    }
    return std::move(*mean);
  }

  LayeredImage render_motion(const StructureUnderTest& structure, std::size_t samples) {
    RenderSettings settings = options_.render;
    settings.samples_per_pixel = samples;
    progress_.stage(fmt::format("{}: {} samples per pixel", scene_.name, samples));
    Rendering rendering = render(scene_, structure, settings, {}, &interruption_.flag());
    progress_.clear();
    if (!rendering.is_complete) {
      throw Interrupted(fmt::format(
          "Interrupted at {} samples per pixel: only the pictures of frozen times are written.", samples));
    }
    return std::move(rendering.image);
  }

  const TruthOptions& options_;
  const Scene& scene_;
  Progress& progress_;
  const Interruption interruption_;
};

void run_truth(const TruthOptions& asked) {
  TruthOptions options = asked;
  if (options.scenes.size() != 1) throw UsageError("--scenes: one scene.");
  if (options.structures.size() != 1) throw UsageError("--structures: one structure.");
  options.render.seed = options.seed;
  make_folder(options.output);
  for (const char* name : {"frozen-times.exr", "motion.exr"})
    check_writable(std::filesystem::path(options.output) / name);
  Progress progress;
  Report report;
  for_each_scene(options, progress, [&](const Scene& scene) {
    progress.clear();
    fmt::print("{}", scene_heading(summarize(scene)));
    std::fflush(stdout);
    report.truths = TruthRun(options, scene, progress).results();
  });
  write_records(options, report);
}

}  // namespace

Work truth_command(CLI::App& app) {
  return make_work(app, run_truth);
}

}  // namespace stbvh::harness
