/// Many frames in one structure, against a structure for each frame.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/session.h"
#include "harness/program/trace.h"
#include "harness/program/usage_error.h"
#include "harness/program/whole_numbers.h"
#include "harness/report/table.h"
#include "harness/scenes/frames.h"

namespace stbvh::harness {
namespace {

constexpr std::array<std::string_view, 3> kStructures{"embree", "lbvh", "stbvh"};
constexpr double kFarOff = 1e-4;  ///< of a distance: farther than the rounding of a ray's time makes it

struct FramesOptions : SessionOptions, RayOptions {
  std::vector<std::string> structures;
  std::vector<std::size_t> frames{24, 240};
  std::size_t sampled = 6;
  std::size_t repeats = 7;
  unsigned threads = 1;
};

void add_options(CLI::App& app, FramesOptions& o) {
  o.scenes = {"wheels", "dancer", "crowd"};
  o.rays = {RayKind::kBounce, RayKind::kUniform};
  o.count = 100'000;
  add_scene_options(app, o);
  add_structures_option(app, o.structures, kStructures);
  add_whole_numbers_option(
      app, "--frames", [&o](const auto& frames) { o.frames = frames; }, "How many, separated by commas")
      ->default_str("24,240");
  add_number_option(app, "--sampled", o.sampled, kMaxSteps, "Frames that are measured, of all");
  add_json_option(app, o);
  add_tables_option(app, o);
  add_rays_option(app, o.rays);
  add_count_option(app, o.count);
  add_threads_option(app, o.threads, kPinnedThreads);
  add_repeats_option(app, o.repeats);
}

/// The rays of a frame in the time of the whole animation.
RaySet in_animation(RaySet set, std::size_t frame, std::size_t frames) {
  for (Ray& ray : set.rays)
    ray.time = static_cast<float>((static_cast<double>(frame) + ray.time) / static_cast<double>(frames));
  return set;
}

/// One animation of one scene.
class FramesRun {
 public:
  FramesRun(const Scene& shutter, std::size_t frames, const FramesOptions& options, PinnedThreads& threads,
            Progress& progress)
      : shutter_(shutter),
        frames_(frames),
        options_(options),
        threads_(threads),
        progress_(progress),
        animation_(played(shutter, frames)) {}

  std::vector<FramesResult> run() {
    std::vector<FramesResult> results;
    const Scene pieces = in_pieces(animation_);
    for (const std::string& name : options_.structures) {
      const Scene& scene = name.starts_with("stbvh") ? animation_ : pieces;
      if (structures_that_fit({name}, scene, "").empty()) continue;
      if (const std::string why = obstacle(name, scene); !why.empty()) {
        progress_.clear();
        fmt::print("{} is left out: {}.\n", name, why);
        continue;
      }
      results.push_back(measure(name, scene));
    }
    return results;
  }

 private:
  FramesResult measure(const std::string& name, const Scene& scene) {
    progress_.stage(fmt::format("{}: {} over {} frames", animation_.name, name, frames_));
    const auto one = build_structure(name, scene, options_.threads);
    FramesResult result{.scene = animation_.name,
                        .structure = name,
                        .frames = frames_,
                        .triangles = animation_.triangle_count(),
                        .threads = options_.threads,
                        .build_s = one->build_record().build_s,
                        .bytes = one->build_record().structure_bytes,
                        .buffer_bytes = animation_.buffer_bytes()};
    std::vector<double> builds, bytes, ones, eaches;
    const std::size_t sampled = std::min(options_.sampled, frames_);
    for (std::size_t i = 0; i < sampled; ++i) {
      const std::size_t frame = (2 * i + 1) * frames_ / (2 * sampled);
      progress_.stage(fmt::format("{}: {}, frame {} of {}", animation_.name, name, frame, frames_));
      const Scene of_frame = frame_of(shutter_, frame);
      const auto each = build_structure(name, of_frame, options_.threads);
      builds.push_back(each->build_record().build_s);
      bytes.push_back(static_cast<double>(each->build_record().structure_bytes));
      for (const RaySet& set :
           make_ray_sets(of_frame, options_, options_.seed, options_.threads, progress_)) {
        if (!set.rays.empty()) trace_both(*one, *each, set, frame, result, ones, eaches);
      }
    }
    result.frame_build_s = spread_of(builds).median;
    result.frame_bytes = static_cast<std::size_t>(spread_of(bytes).median);
    result.mrays_per_s = geometric_mean(ones);
    result.frame_mrays_per_s = geometric_mean(eaches);
    return result;
  }

  void trace_both(const StructureUnderTest& one, const StructureUnderTest& each, const RaySet& set,
                  std::size_t frame, FramesResult& result, std::vector<double>& ones,
                  std::vector<double>& eaches) {
    const RaySet mapped = in_animation(set, frame, frames_);
    std::vector<HitRecord> hits(set.rays.size()), hits_each(set.rays.size());
    std::vector<double> one_s, each_s;
    for (std::size_t repeat = 0; repeat <= options_.repeats; ++repeat) {  // the first warms up
      const double a = trace(threads_, one, mapped, hits);
      const double b = trace(threads_, each, set, hits_each);
      if (repeat == 0) continue;
      one_s.push_back(a);
      each_s.push_back(b);
    }
    const double mrays = static_cast<double>(set.rays.size()) / 1e6;
    ones.push_back(mrays / spread_of(one_s).median);
    eaches.push_back(mrays / spread_of(each_s).median);
    result.traced += set.rays.size();
    result.differing += count_differing(hits, hits_each, kFarOff);
  }

  const Scene& shutter_;
  std::size_t frames_;
  const FramesOptions& options_;
  PinnedThreads& threads_;
  Progress& progress_;
  Scene animation_;
};

void run_frames(const FramesOptions& options) {
  for (const std::size_t frames : options.frames) check_range("--frames", frames, kMaxSteps - 1);
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  std::string tables;
  for_each_scene(options, progress, [&](Scene scene) {
    scene.max_bytes.reset();  // what one frame may take is not what all of them may
    std::vector<FramesResult> results;
    for (const std::size_t frames : options.frames) {
      const auto more = FramesRun(scene, frames, options, threads, progress).run();
      results.insert(results.end(), more.begin(), more.end());
    }
    tables += scene_heading(summarize(scene)) + frames_table(results);
    report.frames.insert(report.frames.end(), results.begin(), results.end());
  });
  progress.clear();
  write_results(options, report, 1, "", tables);
}

}  // namespace

Work frames_command(CLI::App& app) {
  return make_work(app, run_frames);
}

}  // namespace stbvh::harness
