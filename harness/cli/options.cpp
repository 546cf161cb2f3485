#include "harness/cli/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <span>
#include <utility>

#include "harness/cli/check_options.h"
#include "harness/cli/pinned_threads.h"
#include "harness/cli/render_options.h"
#include "harness/cli/report_options.h"
#include "harness/cli/scene_options.h"
#include "harness/cli/usage_error.h"
#include "harness/report/machine.h"

namespace stbvh::harness {
namespace {

void add_scene_options(CLI::App& app, Arguments& a) {
  const std::size_t others = app.get_options().size();
  app.add_option(
         "--scenes", a.options.scenes,
         "Names of built-in scenes (see list), paper (its six), all, .glb, .gltf, .xml (Embree's) and .ecs "
         "files, or .obj files (one for each step: walk_%04d.obj, or a folder); separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  add_making_options(app, a);
  const std::vector<CLI::Option*> all = app.get_options();
  a.scene_options.insert(a.scene_options.end(), all.begin() + static_cast<std::ptrdiff_t>(others), all.end());
}

CLI::App& add_scene_command(CLI::App& app, Arguments& a, const char* name, const char* description) {
  CLI::App& command = *app.add_subcommand(name, description);
  add_scene_options(command, a);
  return command;
}

void add_convert(CLI::App& app, Arguments& a) {
  CLI::App& convert =
      *app.add_subcommand("convert", "Write a scene as XML that Embree's pathtracer and viewer show");
  convert.add_option("scene", a.options.scenes, "A built-in scene (see list) or a file, as in --scenes")
      ->expected(1)
      ->required();
  convert
      .add_option("-o,--output", a.converted,
                  "File.xml; for a large scene, a File.bin beside it has positions and triangles")
      ->required();
  add_making_options(convert, a);
}

void add_common_options(CLI::App& app, Arguments& a, const std::string& default_structures) {
  app.add_option("--structures", a.options.structures,
                 "Names of structures (see list), or all; separated by commas")
      ->delimiter(',')
      ->default_str(default_structures);
  app.add_option("--json", a.json, "File for the records");
}

void add_tables_option(CLI::App& app, Arguments& a) {
  app.add_option("--tables", a.tables, "File for all tables, of which the screen has a summary");
}

void add_threads_option(CLI::App& app, Arguments& a) {
  app.add_option("--threads", a.options.threads, "Threads, each pinned to a core; also of the builds")
      ->default_str("all cores");
}

void add_trace_options(CLI::App& app, Arguments& a, std::size_t default_count) {
  add_common_options(app, a, "all");
  add_tables_option(app, a);
  app.add_option("--rays", a.rays, "primary, bounce, uniform, shadow, bounce-occluded, uniform-occluded")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--count", a.options.count, "Rays of each kind")->default_str(std::to_string(default_count));
}

void add_bench(CLI::App& app, Arguments& a) {
  CLI::App& bench =
      add_scene_command(app, a, "bench", "Build each structure, trace the same rays interleaved, compare");
  add_trace_options(bench, a, kDefaultBenchRays);
  bench
      .add_option("--threads", a.options.thread_counts,
                  "Threads, each pinned to a core; several counts, separated by commas: speeds with each of "
                  "them, builds with the largest")
      ->delimiter(',')
      ->default_str("all cores");
  bench.add_option("--repeats", a.options.repeats, "How often each ray set is traced")->capture_default_str();
  bench
      .add_option("--build-budget", a.options.build_budget_s,
                  "Seconds within which a structure is built again, for the median; 0: built once")
      ->capture_default_str();
}

void add_error(CLI::App& app, Arguments& a) {
  CLI::App& error =
      add_scene_command(app, a, "error", "Compare what each structure answers with an exact oracle");
  add_trace_options(error, a, kDefaultErrorRays);
  add_threads_option(error, a);
}

std::string names_of(std::span<const std::string_view> structures) {
  return fmt::format("{}", fmt::join(structures, ","));
}

void add_hard(CLI::App& app, Arguments& a) {
  CLI::App& hard = *app.add_subcommand(
      "hard", "Compare what each structure answers to the catalogue of hard cases with the oracle");
  add_common_options(hard, a, names_of(kHardStructures));
  add_tables_option(hard, a);
  add_threads_option(hard, a);
  hard.add_option("--families", a.options.families,
                  "Families of hard cases (see list), or all; separated by commas")
      ->delimiter(',')
      ->default_str("all");
  hard.add_option("--count", a.options.count, "Rays of each family")
      ->default_str(std::to_string(kDefaultHardRays));
  hard.add_option("--seed", a.options.seed, "Seed of scenes and rays")->capture_default_str();
}

void add_pareto(CLI::App& app, Arguments& a) {
  CLI::App& pareto = add_scene_command(
      app, a, "pareto",
      "Speed against error: scenes for speed, hard cases for error, a point for each structure");
  add_common_options(pareto, a, names_of(kParetoStructures));
  add_tables_option(pareto, a);
  add_threads_option(pareto, a);
  pareto.add_option("--count", a.options.count, "Rays of each family of hard cases")
      ->default_str(std::to_string(kDefaultParetoRays));
  pareto.add_option("--repeats", a.options.repeats, "Times that each ray set is traced")
      ->capture_default_str();
  pareto
      .add_option(
          "--from", a.options.record_files,
          "Files of bench and hard with speeds and hard cases, separated by commas: nothing is measured")
      ->delimiter(',');
  pareto.add_option("--plot", a.plot, "PNG file for the plot; needs --json and python3-matplotlib");
}

void add_scaling(CLI::App& app, Arguments& a) {
  CLI::App& scaling = *app.add_subcommand(
      "scaling",
      "Bytes, build time and speed of each structure as a scene grows in steps or triangles, or "
      "with threads");
  scaling.add_option("--over", a.over, "steps, triangles (only builds), or threads")->required();
  scaling
      .add_option("--values", a.options.values,
                  "How many of them, separated by commas. Default: 2 to 129 steps, 100000 to 1000000 "
                  "triangles, 1 to all threads")
      ->delimiter(',');
  scaling.add_option("--scene", a.scene, "Built-in scene of any number of steps: cloth or barbarian-rotate")
      ->capture_default_str();
  add_scale_option(scaling, a);
  scaling.add_option("--seed", a.options.seed, "Seed of scene and rays")->capture_default_str();
  add_common_options(scaling, a, "all");
  add_threads_option(scaling, a);
  scaling.add_option("--count", a.options.count, "Rays of each kind")
      ->default_str(std::to_string(kDefaultScalingRays));
  scaling.add_option("--repeats", a.options.repeats, "Times that each ray set is traced")
      ->capture_default_str();
  scaling
      .add_option("--build-budget", a.options.build_budget_s,
                  "Seconds within which a structure is built again, for the median; one whose build took "
                  "longer is left out of larger scenes. 0: built once, none left out")
      ->default_str(fmt::format("{}", kScalingBuildBudget));
}

void add_charts(CLI::App& app, Arguments& a) {
  CLI::App& charts = *app.add_subcommand(
      "charts", "Draw the records of bench and scaling: speed, bytes, build time (needs python3-matplotlib)");
  charts.add_option("records", a.options.record_files, "Files that bench and scaling wrote with --json")
      ->required();
  charts.add_option("-o,--output", a.directory, "Directory for the charts")->required();
  charts
      .add_option(
          "--structures", a.options.structures,
          "Names of structures in the records, separated by commas, in the order in which they are drawn")
      ->delimiter(',')
      ->default_str("all");
  charts.add_option("--format", a.options.chart_format, "svg or png")
      ->check(CLI::IsMember({"svg", "png"}))
      ->capture_default_str();
}

void add_results(CLI::App& app, Arguments& a) {
  CLI::App& results = *app.add_subcommand(
      "results", "A page of the records of bench, error and hard on several machines, side by side");
  results.add_option("records", a.options.record_files, "Files that bench, error and hard wrote with --json")
      ->required();
  results
      .add_option(
          "-o,--output", a.output,
          "Markdown file; where it has the markers of an earlier page, only what is between them is replaced")
      ->required();
}

void add_render(CLI::App& app, Arguments& a) {
  add_render_options(
      add_scene_command(
          app, a, "render",
          "Path-traced pictures of each scene through each structure, as OpenEXR files of many layers"),
      a);
}

void add_truth_and_report(CLI::App& app, Arguments& a) {
  add_truth_options(
      add_scene_command(
          app, a, "truth",
          "Compare motion blur with the mean of renderings at frozen times; the default scene is wheels"),
      a);
  add_report_options(
      add_scene_command(
          app, a, "report",
          "One page of everything in one file: figures, charts, pictures, how to make them again"),
      a);
}

/// The words of a command line as a shell takes them.
std::string joined(int argc, const char* const* argv) {
  std::string text = "stbvh-ab";
  for (int i = 1; i < argc; ++i) text += " " + shell_word(argv[i]);
  return text;
}

void add_compare(CLI::App& app, Arguments& a) {
  CLI::App& compare = *app.add_subcommand(
      "compare", "Compare a picture with a reference: RMSE, relative MSE, FLIP, the worst pixels");
  compare.add_option("picture", a.options.picture, "OpenEXR file with R, G and B")->required();
  compare.add_option("reference", a.options.reference, "OpenEXR file of the same size")->required();
  compare.add_option("--png", a.difference_png,
                     "File for a picture of the differences (FLIP), with its scale");
  compare.add_option("--json", a.json, "File for the record");
}

}  // namespace

bool parse_command_line(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) throw UsageError(e.what());
    app.exit(e);
    return false;
  }
  return true;
}

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Arguments a;
  a.options.threads = usable_core_count();
  CLI::App app(
      "Compares our STBVH with Embree's own trees and LBVHs: speed, memory, and errors against an exact "
      "oracle.",
      "stbvh-ab");
  app.set_version_flag("--version", built_commit());
  app.require_subcommand(1);
  app.add_subcommand("list", "Names of scenes, structures, kinds of rays and families of hard cases");
  add_bench(app, a);
  add_error(app, a);
  add_hard(app, a);
  add_pareto(app, a);
  add_scaling(app, a);
  add_charts(app, a);
  add_results(app, a);
  add_render(app, a);
  add_compare(app, a);
  add_truth_and_report(app, a);
  add_convert(app, a);
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  a.options.command_line = joined(argc, argv);
  return checked_options(std::move(a), *app.get_subcommands().front());
}

}  // namespace stbvh::harness
