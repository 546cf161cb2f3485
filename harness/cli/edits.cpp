/// What changes of a scene cost: commits after random edits, and how fast rays are then, against building
/// anew.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/cli/wrong_answers.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/session.h"
#include "harness/program/trace.h"
#include "harness/program/usage_error.h"
#include "harness/report/table.h"
#include "harness/scenes/scene_editor.h"

namespace stbvh::harness {
namespace {

constexpr std::array<std::string_view, 2> kStructures{"embree", "stbvh"};
constexpr std::size_t kMostEdits = 1'000'000;

struct EditsOptions : SessionOptions, RayOptions {
  std::vector<std::string> structures;
  std::vector<EditKind> kinds;
  std::size_t edits = 100;
  std::size_t every = 7;  // so that all kinds have their turn
  std::size_t repeats = 7;
  unsigned threads = 1;
};

void add_options(CLI::App& app, EditsOptions& o) {
  o.scenes = {"crowd"};
  o.rays = {RayKind::kUniform};
  o.count = 100'000;
  for (std::size_t i = 0; i < edit_kind_names().size(); ++i) o.kinds.push_back(static_cast<EditKind>(i));
  add_scene_options(app, o);
  add_structures_option(app, o.structures, kStructures);
  app.add_option_function<std::vector<std::string>>(
         "--kinds",
         [&o](const auto& names) {
           o.kinds.clear();
           for (const std::string& name : chosen_names("kind of edit", names, edit_kind_names()))
             o.kinds.push_back(static_cast<EditKind>(index_of("kind of edit", name, edit_kind_names())));
         },
         fmt::format("Kinds of edits, separated by commas: {}", fmt::join(edit_kind_names(), ", ")))
      ->delimiter(',')
      ->default_str("all");
  add_number_option(app, "--edits", o.edits, kMostEdits, "How many, one after another");
  add_number_option(app, "--every", o.every, kMostEdits,
                    "After how many of them structures are built anew too, and rays traced through both");
  add_json_option(app, o);
  add_tables_option(app, o);
  add_rays_option(app, o.rays);
  add_count_option(app, o.count);
  add_threads_option(app, o.threads, kPinnedThreads);
  add_repeats_option(app, o.repeats);
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One scene under edits.
class EditsRun {
 public:
  EditsRun(const Scene& scene, const EditsOptions& options, PinnedThreads& threads, Progress& progress)
      : scene_(scene),
        options_(options),
        threads_(threads),
        progress_(progress),
        editor_(scene_, options.seed) {}

  std::vector<EditResult> run() {
    for (const std::string& name : structures_that_fit(options_.structures, scene_, "")) {
      progress_.stage(fmt::format("{}: building {}", scene_.name, name));
      auto structure = build_within_limit(name, scene_, options_.threads);
      if (structure == nullptr) continue;
      structures_.push_back({name, std::move(structure)});
    }
    for (std::size_t i = 0; i < options_.edits; ++i) edit(i + 1);
    return std::move(results_);
  }

 private:
  struct Updated {
    std::string name;
    std::unique_ptr<StructureUnderTest> structure;
  };

  void edit(std::size_t number) {
    const EditKind kind = options_.kinds[(number - 1) % options_.kinds.size()];
    const std::string what(edit_kind_names()[static_cast<std::size_t>(kind)]);
    progress_.stage(fmt::format("{}: edit {} of {}, {}", scene_.name, number, options_.edits, what));
    const std::vector<MeshEdit> edits = editor_.apply(kind);
    std::size_t changed = 0;
    for (const MeshEdit& edit : edits) changed += scene_.meshes[edit.mesh].triangle_count();
    const std::size_t triangles = scene_.triangle_count();
    for (Updated& updated : structures_) {
      EditResult result{.scene = scene_.name,
                        .structure = updated.name,
                        .edit = number,
                        .what = what,
                        .triangles = triangles,
                        .changed_share = static_cast<double>(changed) / static_cast<double>(triangles),
                        .threads = options_.threads};
      result.commit_s = seconds_of([&] { updated.structure->update(scene_, edits); });
      results_.push_back(result);
    }
    if (number % options_.every == 0) compare();
  }

  /// Fills in the last results what structures built anew say.
  void compare() {
    const std::vector<RaySet> rays =
        make_ray_sets(scene_, options_, options_.seed, options_.threads, progress_);
    const std::size_t first = results_.size() - structures_.size();
    for (std::size_t s = 0; s < structures_.size(); ++s) {
      const std::string& name = structures_[s].name;
      progress_.stage(fmt::format("{}: building {} anew", scene_.name, name));
      std::unique_ptr<StructureUnderTest> anew;
      const double seconds = seconds_of([&] { anew = build_structure(name, scene_, options_.threads); });
      results_[first + s].rebuild_s = seconds;
      const EditResult commit = results_[first + s];
      for (const RaySet& set : rays) {
        if (set.rays.empty()) continue;
        // One record for each kind of rays.
        EditResult& result =
            results_[first + s].rays.empty() ? results_[first + s] : results_.emplace_back(commit);
        hold_against(*structures_[s].structure, *anew, set, result);
      }
    }
  }

  void hold_against(const StructureUnderTest& updated, const StructureUnderTest& anew, const RaySet& set,
                    EditResult& result) {
    result.rays = ray_kind_name(set.kind);
    result.traced = set.rays.size();
    const StructureUnderTest* const both[] = {&updated, &anew};
    const TraceTimes times = trace_interleaved(threads_, both, set, options_.repeats, [](std::size_t) {});
    std::vector<double> ratios;
    for (std::size_t r = 0; r < options_.repeats; ++r)
      ratios.push_back(times.seconds[1][r] / times.seconds[0][r]);
    result.speed = spread_of(ratios);
    std::vector<HitRecord> hits(set.rays.size()), hits_anew(set.rays.size());
    trace(threads_, updated, set, hits);
    trace(threads_, anew, set, hits_anew);
    result.differing = count_differing(hits, hits_anew, 0.0);
  }

  Scene scene_;
  const EditsOptions& options_;
  PinnedThreads& threads_;
  Progress& progress_;
  SceneEditor editor_;
  std::vector<Updated> structures_;
  std::vector<EditResult> results_;
};

void require_right_answers(const std::vector<EditResult>& results) {
  std::size_t differing = 0;
  for (const EditResult& r : results) differing += is_exact(r.structure) ? r.differing : 0;
  if (differing > 0)
    throw WrongAnswers(
        fmt::format("{} rays are answered otherwise than by a structure built anew.", differing));
}

void run_edits(const EditsOptions& options) {
  for (const std::string& name : options.structures) {
    if (!is_updatable(name)) throw UsageError(fmt::format("--structures: {} cannot be updated.", name));
  }
  Progress progress;
  Report report;
  PinnedThreads threads(options.threads);
  std::string tables;
  for_each_scene(options, progress, [&](const Scene& scene) {
    const std::vector<EditResult> results = EditsRun(scene, options, threads, progress).run();
    tables += scene_heading(summarize(scene)) + edits_table(results);
    report.edits.insert(report.edits.end(), results.begin(), results.end());
  });
  progress.clear();
  write_results(options, report, 1, "", tables);
  require_right_answers(report.edits);
}

}  // namespace

Work edits_command(CLI::App& app) {
  return make_work(app, run_edits);
}

}  // namespace stbvh::harness
