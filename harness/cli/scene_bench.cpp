#include "harness/cli/scene_bench.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <utility>

#include "harness/cli/commands.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/trace.h"
#include "harness/program/usage_error.h"
#include "harness/program/whole_numbers.h"
#include "harness/report/table.h"
#include "harness/structures/memory_estimate.h"

namespace stbvh::harness {
namespace {

constexpr std::string_view kRatioReference = "embree";

/// Bench of one scene.
class SceneBench {
 public:
  SceneBench(const Scene& scene, const SpeedOptions& options, std::uint64_t seed, Progress& progress,
             const OnBuilt& on_built)
      : scene_(scene), options_(options), seed_(seed), progress_(progress), on_built_(on_built) {}

  SceneFigures run(std::vector<std::string> names) {
    if (options_.rays.empty()) {
      names = structures_that_fit(names, scene_, "");
      for (const std::string& name : names) build(name);
    } else {
      names = structures_that_fit(names, scene_, kRatioReference);
      const std::vector<RaySet> rays = make_ray_sets(scene_, options_, seed_, options_.threads(), progress_);
      for (const auto& group : groups_in_memory(names)) trace_group(group, rays);
    }
    std::erase_if(names, [&](const std::string& name) { return builds_.at(name).empty(); });
    build_again(names);
    SceneFigures figures{{}, std::move(speeds_)};
    for (const std::string& name : names) figures.builds.push_back(build_result(name));
    return figures;
  }

 private:
  using StructurePtr = std::unique_ptr<StructureUnderTest>;

  /// Structures that are traced against each other must all be in memory; where they do not fit, each group
  /// has the reference for itself.
  std::vector<std::vector<std::string>> groups_in_memory(const std::vector<std::string>& names) const {
    const std::size_t available = available_memory_bytes();
    std::vector<std::vector<std::string>> groups;
    std::size_t used = 0;
    for (const std::string& name : names) {
      const std::size_t needed = estimate_peak_bytes(name, scene_);
      if (groups.empty() || used + needed > available) {
        const bool has_reference = !groups.empty() && names.front() == kRatioReference;
        groups.push_back(has_reference ? std::vector<std::string>{names.front()}
                                       : std::vector<std::string>{});
        used = has_reference ? estimate_peak_bytes(names.front(), scene_) : 0;
      }
      groups.back().push_back(name);
      used += needed;
    }
    return groups;
  }

  /// Null, having told, where it cannot keep to the scene's limit of memory.
  StructurePtr build(const std::string& name) {
    std::vector<BuildRecord>& builds = builds_[name];
    progress_.stage(fmt::format("{}: building {} ({})", scene_.name, name, builds.size() + 1));
    StructurePtr structure = build_within_limit(name, scene_, options_.threads());
    if (structure != nullptr) builds.push_back(structure->build_record());
    return structure;
  }

  void trace_group(const std::vector<std::string>& group, const std::vector<RaySet>& rays) {
    std::vector<std::string> names;
    std::vector<StructurePtr> structures;
    std::vector<const StructureUnderTest*> pointers;
    for (const std::string& name : group) {
      StructurePtr structure = build(name);
      if (structure == nullptr) continue;
      if (on_built_) on_built_(name, *structure, rays);
      names.push_back(name);
      pointers.push_back(structure.get());
      structures.push_back(std::move(structure));
    }
    for (unsigned count : options_.thread_counts) {
      PinnedThreads threads(count);
      for (const RaySet& set : rays) {
        if (set.rays.empty()) continue;
        const TraceTimes times =
            trace_interleaved(threads, pointers, set, options_.repeats, [&](std::size_t repeat) {
              progress_.stage(fmt::format("{}: tracing {}, {} threads, {} of {}", scene_.name,
                                          ray_kind_name(set.kind), count, repeat, options_.repeats));
            });
        for (std::size_t s = 0; s < names.size(); ++s) add_speed(names, s, set, count, times);
      }
    }
  }

  void add_speed(const std::vector<std::string>& names, std::size_t s, const RaySet& set, unsigned threads,
                 const TraceTimes& times) {
    const auto is_known = [&](const SpeedResult& r) {
      return r.structure == names[s] && r.rays == ray_kind_name(set.kind) && r.threads == threads;
    };
    if (std::any_of(speeds_.begin(), speeds_.end(), is_known)) return;  // the reference, in a later group
    const bool has_reference = names.front() == kRatioReference;
    std::vector<double> mrays;
    std::vector<double> ratios;
    for (std::size_t r = 0; r < options_.repeats; ++r) {
      mrays.push_back(static_cast<double>(set.rays.size()) / times.seconds[s][r] / 1e6);
      if (has_reference) ratios.push_back(times.seconds.front()[r] / times.seconds[s][r]);
    }
    speeds_.push_back({.scene = scene_.name,
                       .structure = names[s],
                       .rays = std::string(ray_kind_name(set.kind)),
                       .ray_count = set.rays.size(),
                       .threads = threads,
                       .repeats = options_.repeats,
                       .mrays_per_s = spread_of(mrays),
                       .ratios_to_embree = ratios,
                       .hits = times.hits[s]});
  }

  /// More builds for the median, all structures in turn, while each one's time lasts.
  void build_again(const std::vector<std::string>& names) {
    for (std::size_t round = 1; round < options_.repeats; ++round) {
      for (const std::string& name : names) {
        double seconds = 0;
        for (const BuildRecord& record : builds_[name]) seconds += record.build_s;
        if (seconds + seconds / static_cast<double>(builds_[name].size()) <= options_.build_budget_s)
          build(name);
      }
    }
  }

  BuildResult build_result(const std::string& name) const {
    const std::vector<BuildRecord>& builds = builds_.at(name);
    std::vector<double> seconds;
    for (const BuildRecord& record : builds) seconds.push_back(record.build_s);
    const BuildRecord& first = builds.front();
    return {.scene = scene_.name,
            .structure = name,
            .triangles = scene_.triangle_count(),
            .primitive_segments = scene_.primitive_segment_count(),
            .threads = options_.threads(),
            .builds = builds.size(),
            .build_s = spread_of(seconds),
            .peak_bytes = first.peak_bytes,
            .structure_bytes = first.structure_bytes,
            .monitor_bytes = first.monitor_bytes,
            .total_bytes = first.structure_bytes + scene_.buffer_bytes(),
            .resident_bytes = first.resident_bytes,
            .budget_bytes = scene_.max_bytes.value_or(0),
            .wanted_bytes = first.wanted_bytes,
            .steps = scene_.step_count(),
            .steps_kept = first.steps_kept,
            .tolerance = scene_.tolerance,
            .max_deviation = first.max_deviation};
  }

  const Scene& scene_;
  const SpeedOptions& options_;
  std::uint64_t seed_;
  Progress& progress_;
  const OnBuilt& on_built_;
  std::map<std::string, std::vector<BuildRecord>> builds_;
  std::vector<SpeedResult> speeds_;
};

void set_thread_counts(std::vector<std::size_t> counts, std::vector<unsigned>& result) {
  for (const std::size_t count : counts) check_range("--threads", count, usable_core_count());
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  result.clear();
  for (const std::size_t count : counts) result.push_back(static_cast<unsigned>(count));
}

}  // namespace

void add_build_budget_option(CLI::App& app, double& budget_s, const char* description) {
  const auto take = [&budget_s](double seconds) {
    if (!(seconds >= 0) || !std::isfinite(seconds))
      throw UsageError(fmt::format("--build-budget must be at least 0 seconds, not {}.", seconds));
    budget_s = seconds;
  };
  app.add_option_function<double>("--build-budget", take, description)
      ->default_str(fmt::format("{}", budget_s));
}

void add_options(CLI::App& app, BenchOptions& o) {
  o.count = kDefaultBenchRays;
  o.thread_counts = {usable_core_count()};
  add_scene_options(app, o);
  add_structures_option(app, o.structures);
  add_json_option(app, o);
  add_tables_option(app, o);
  add_rays_option(app, o.rays);
  add_count_option(app, o.count);
  add_whole_numbers_option(
      app, "--threads", [&o](const auto& counts) { set_thread_counts(counts, o.thread_counts); },
      "Threads, each pinned to a core; several counts, separated by commas: speeds with each of "
      "them, builds with the largest")
      ->default_str("all cores");
  add_repeats_option(app, o.repeats);
  add_build_budget_option(app, o.build_budget_s,
                          "Seconds within which a structure is built again, for the median; 0: built once");
}

Work bench_command(CLI::App& app) {
  return make_work(app, run_bench);
}

std::vector<std::string> with_reference(std::vector<std::string> names) {
  std::erase(names, kRatioReference);
  names.insert(names.begin(), std::string(kRatioReference));
  return names;
}

SceneFigures measure_scene(const Scene& scene, const std::vector<std::string>& names,
                           const SpeedOptions& options, std::uint64_t seed, Progress& progress,
                           const OnBuilt& on_built) {
  return SceneBench(scene, options, seed, progress, on_built).run(names);
}

void add_scaling_results(const SceneFigures& figures, const std::string& over, std::size_t value,
                         std::vector<ScalingResult>& results) {
  for (const BuildResult& build : figures.builds) {
    ScalingResult& result = results.emplace_back(ScalingResult{.over = over, .value = value, .build = build});
    std::ranges::copy_if(figures.speeds, std::back_inserter(result.speeds),
                         [&](const SpeedResult& s) { return s.structure == build.structure; });
  }
}

std::string bench_scene(const Scene& scene, const BenchOptions& options, Progress& progress, Report& report) {
  const SceneFigures figures =
      measure_scene(scene, with_reference(options.structures), options, options.seed, progress);
  std::string tables = scene_heading(summarize(scene)) + build_table(figures.builds);
  for (unsigned count : options.thread_counts) {
    std::vector<SpeedResult> speeds;
    std::copy_if(figures.speeds.begin(), figures.speeds.end(), std::back_inserter(speeds),
                 [&](const SpeedResult& r) { return r.threads == count; });
    tables += fmt::format("\n{}", speed_table(speeds));
  }
  report.builds.insert(report.builds.end(), figures.builds.begin(), figures.builds.end());
  report.speeds.insert(report.speeds.end(), figures.speeds.begin(), figures.speeds.end());
  return tables;
}

}  // namespace stbvh::harness
