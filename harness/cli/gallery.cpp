/// The methods that came before the STBVH, and ours without its ideas, beside each other.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/cli/gallery_growth.h"
#include "harness/cli/gallery_scene.h"
#include "harness/cli/gallery_slices.h"
#include "harness/cli/scene_bench.h"
#include "harness/cli/wrong_answers.h"
#include "harness/program/make_folder.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/script.h"
#include "harness/program/session.h"
#include "harness/program/usage_error.h"
#include "harness/program/whole_numbers.h"
#include "harness/report/gallery_table.h"
#include "harness/report/machine.h"
#include "harness/report/summary.h"
#include "harness/report/table.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostTriangles = 10'000'000;
constexpr double kBuildBudget = 1;  // seconds

struct GalleryOptions : SessionOptions, RayOptions {
  std::vector<std::string> structures;
  std::string output;  ///< folder
  std::size_t threads = 1;
  std::size_t repeats = 7;
  std::size_t growth = 20'000;  ///< triangles; 0: no growth
  bool no_pictures = false;
};

/// Those of the gallery, and what they are held against.
std::vector<std::string_view> default_structures() {
  std::vector<std::string_view> names = gallery_names();
  for (const std::string_view name : {"embree", "lbvh", "stbvh-direct", "stbvh-direct-scalar"})
    names.push_back(name);
  return names;
}

void add_options(CLI::App& app, GalleryOptions& o) {
  o.count = 20'000;
  add_scene_options(app, o);
  add_structures_option(app, o.structures, default_structures())
      ->default_str("all of the gallery (see list --gallery), embree, lbvh and ours");
  const auto take_output = [&o](const std::string& folder) {
    if (folder.empty()) throw UsageError("--output: a folder is needed.");
    o.output = folder;
  };
  app.add_option_function<std::string>("-o,--output", take_output,
                                       "Folder for tables, records and pictures; made if it is not there")
      ->required();
  add_json_option(app, o, "File for the records; gallery.json in the folder where it is not given");
  add_rays_option(app, o.rays);
  add_count_option(app, o.count);
  add_number_option(app, "--threads", o.threads, usable_core_count(), kPinnedThreads);
  add_repeats_option(app, o.repeats);
  add_whole_number_option(
      app, "--growth",
      [&o](std::size_t triangles) {
        if (triangles > 0) check_range("--growth", triangles, kMostTriangles);
        o.growth = triangles;
      },
      "Triangles of the scenes whose steps and turns grow; 0: none do")
      ->default_str(std::to_string(o.growth));
  app.add_flag("--no-pictures", o.no_pictures, "Only tables and records: without python3-matplotlib");
}

/// With what the others are held against: `embree` in front, as ratios are taken by way of it.
std::vector<std::string> with_references(const std::vector<std::string>& names) {
  std::vector<std::string> all = with_reference(names);
  const auto add = [&](std::string_view name) {
    if (std::ranges::find(all, name) == all.end()) all.emplace_back(name);
  };
  add(kGalleryReferences[0]);
  if (std::ranges::any_of(names, [](const std::string& name) { return is_scalar(name); }))
    add(kGalleryReferences[1]);
  return all;
}

/// The gallery in its order, then what it is held against.
std::vector<std::string> in_order(const std::vector<std::string>& names) {
  std::vector<std::string> ordered;
  for (const std::string_view name : gallery_names()) {
    if (std::ranges::find(names, name) != names.end()) ordered.emplace_back(name);
  }
  for (const std::string& name : names) {
    if (std::ranges::find(ordered, name) == ordered.end()) ordered.push_back(name);
  }
  return ordered;
}

SpeedOptions speed_options(const GalleryOptions& options) {
  SpeedOptions speed;
  static_cast<RayOptions&>(speed) = options;
  speed.thread_counts = {static_cast<unsigned>(options.threads)};
  speed.repeats = options.repeats;
  speed.build_budget_s = kBuildBudget;
  return speed;
}

void append(const Report& part, Report& whole) {
  const auto add = [](const auto& from, auto& to) { to.insert(to.end(), from.begin(), from.end()); };
  add(part.builds, whole.builds);
  add(part.speeds, whole.speeds);
  add(part.errors, whole.errors);
  add(part.galleries, whole.galleries);
}

/// A name of a scene as one of a file: files with scenes may be called anything.
std::string file_name(std::string scene) {
  std::ranges::replace_if(
      scene, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '.' && c < 0x80; }, '_');
  return scene;
}

class GalleryRun {
 public:
  explicit GalleryRun(const GalleryOptions& options)
      : options_(options),
        names_(with_references(options.structures)),
        speed_(speed_options(options)),
        threads_(speed_.threads()) {}

  void run() {
    for_each_scene(options_, progress_, [&](const Scene& scene) { run_scene(scene); });
    report_.summaries = summarize_scenes(report_, kGalleryReferences);
    if (options_.growth > 0)
      report_.scalings = measure_growth(names_, speed_, options_.growth, options_.seed, progress_);
    report_.slices = slices_of(in_order(names_), progress_);
    progress_.clear();
    const std::string table = gallery_table(report_.galleries, report_.summaries);
    fmt::print("{}", table);
    write("gallery.txt", table);
    write_records(options_, report_);
    if (!options_.no_pictures)
      run_script("charts.py", {"--output=" + options_.output, "--format=png", "--", options_.json->string()});
    require_right_answers(report_.errors);
  }

 private:
  void run_scene(const Scene& scene) {
    GalleryScene gallery(scene, threads_, progress_);
    std::vector<std::string> names = names_;
    std::erase_if(names, [&](const std::string& name) { return !obstacle(name, scene).empty(); });
    SceneFigures figures =
        measure_scene(scene, names, speed_, options_.seed, progress_,
                      [&](const std::string& name, const StructureUnderTest& structure,
                          std::span<const RaySet> sets) { gallery.on_built(name, structure, sets); });
    Report part;
    part.builds = std::move(figures.builds);
    part.speeds = std::move(figures.speeds);
    part.errors = gallery.errors();
    part.galleries = gallery.results(in_order(names_));
    append(part, report_);
    const std::string table = gallery_table(part.galleries, summarize_scenes(part, kGalleryReferences));
    write(file_name(scene.name) + ".txt", scene_heading(summarize(scene)) + table + build_table(part.builds) +
                                              "\n" + speed_table(part.speeds) + error_table(part.errors) +
                                              distance_table(part.errors) + difference_lines(part.errors));
  }

  void write(const std::string& name, const std::string& text) const {
    write_file(fs::path(options_.output) / name, machine_line(this_machine(), built_commit()) + text);
  }

  const GalleryOptions& options_;
  std::vector<std::string> names_;  ///< as they are measured
  SpeedOptions speed_;
  PinnedThreads threads_;
  Progress progress_;
  Report report_;
};

void run_gallery(const GalleryOptions& asked) {
  GalleryOptions options = asked;
  find_scenes(options);  // refused before a folder is made
  make_folder(options.output);
  if (!options.json) options.json = fs::path(options.output) / "gallery.json";
  GalleryRun(options).run();
}

}  // namespace

Work gallery_command(CLI::App& app) {
  return make_work(app, run_gallery);
}

}  // namespace stbvh::harness
