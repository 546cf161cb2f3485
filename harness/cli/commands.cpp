#include "harness/cli/commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <utility>
#include <vector>

#include "harness/hard_cases/hard_case.h"
#include "harness/program/program.h"
#include "harness/program/scene_options.h"
#include "harness/rays/ray_generator.h"
#include "harness/report/machine.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

struct ListOptions {
  bool families = false;
  bool gallery = false;
};

void add_options(CLI::App& app, ListOptions& o) {
  app.add_flag("--families", o.families, "The families of hard cases instead, and what they are");
  app.add_flag("--gallery", o.gallery, "The structures of the gallery instead, and what they are");
}

void run_list(const ListOptions& options) {
  if (options.gallery) {
    for (std::string_view name : gallery_names())
      fmt::print("{:<25} {}\n", name, structure_description(name));
    return;
  }
  if (options.families) {
    for (const HardFamily& family : hard_families())
      fmt::print("{:<25} {}\n", family.name, family.description);
    return;
  }
  fmt::print("scenes (or a .glb, .gltf, .xml, .ecs or .stbvh file, or .obj files)\n");
  for (const ProceduralScene& scene : procedural_scenes()) {
    fmt::print("  {:<17} {} (default scale {})\n", scene.name, scene.description, scene.default_scale);
  }
  fmt::print("structures\n");
  for (std::string_view name : structure_names()) {
    fmt::print("  {:<21} {}\n", name, structure_description(name));
  }
  fmt::print("rays\n ");
  for (RayKind kind : ray_kinds()) fmt::print(" {}", ray_kind_name(kind));
  fmt::print("\n{} families of hard cases: stbvh-ab list --families\n", hard_families().size());
  fmt::print("{} structures of the gallery: stbvh-ab list --gallery\n", gallery_names().size());
}

Work list_command(CLI::App& app) {
  return make_work(app, run_list);
}

struct Command {
  const char* name;
  Work (*add)(CLI::App& app);
  const char* description;
};
constexpr Command kCommands[] = {
    {"list", list_command, "Names of scenes, structures and kinds of rays"},
    {"bench", bench_command, "Build each structure, trace the same rays interleaved, compare"},
    {"error", error_command, "Compare what each structure answers with an exact oracle"},
    {"hard", hard_command,
     "Compare what each structure answers to the catalogue of hard cases with the oracle"},
    {"pareto", pareto_command,
     "Speed against error: scenes for speed, hard cases for error, a point for each structure"},
    {"scaling", scaling_command,
     "Bytes, build time and speed of each structure as a scene grows in steps or triangles, or "
     "with threads"},
    {"edits", edits_command,
     "What a change of the scene costs: commit time and speed after random edits, against building anew"},
    {"frames", frames_command,
     "Many frames of an animation in one structure, against a structure for each frame"},
    {"gallery", gallery_command,
     "The methods before ours, and ours without its ideas: exactness, speed, visits, bytes, growth, "
     "pictures"},
    {"charts", charts_command,
     "Draw the records of bench and scaling: speed, bytes, build time (needs python3-matplotlib)"},
    {"results", results_command,
     "A page of the records of bench, error and hard on several machines, side by side"},
    {"render", render_command,
     "Path-traced pictures of each scene through each structure, as OpenEXR files of many layers"},
    {"merge", merge_command, "Join the tiles of a picture that were rendered apart (render --tile)"},
    {"compare", compare_command,
     "Compare a picture with a reference: RMSE, relative MSE, FLIP, the worst pixels"},
    {"truth", truth_command,
     "Compare motion blur with the mean of renderings at frozen times; the default scene is wheels"},
    {"report", report_command,
     "One page of everything in one file: figures, charts, pictures, how to make them again"},
    {"build", build_command, "Write a scene with its structure, built once, to a file that --scenes takes"},
    {"convert", convert_command, "Write a scene as XML that Embree's pathtracer and viewer show"},
};

/// The words of a command line as a shell takes them.
std::string joined(int argc, const char* const* argv) {
  std::string text = "stbvh-ab";
  for (int i = 1; i < argc; ++i) text += fmt::format(" {}", shell_word(argv[i]));
  return text;
}

void run(int argc, const char* const* argv) {
  CLI::App app("Our STBVH against Embree's own tree and LBVHs: speed, memory, and error against an oracle.",
               "stbvh-ab");
  app.set_version_flag("--version", version_text("stbvh-ab"));
  app.set_help_all_flag("--help-all", "Print the help of all commands and exit");
  app.require_subcommand(1);
  std::vector<std::pair<const CLI::App*, Work>> commands;
  for (const Command& c : kCommands) {
    CLI::App& command = *app.add_subcommand(c.name, c.description);
    commands.emplace_back(&command, c.add(command));
  }
  if (!parse_command_line(app, argc, argv)) return;
  for (const auto& [command, work] : commands) {
    if (command->parsed()) work(joined(argc, argv));
  }
}

}  // namespace

int run_program(int argc, const char* const* argv) {
  return run_as_program([&] { run(argc, argv); });
}

}  // namespace stbvh::harness
