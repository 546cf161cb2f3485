/// A scene with its structure, built once, in a file that other commands take as a scene.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/program/progress.h"
#include "harness/program/scene_options.h"
#include "harness/program/scene_source.h"
#include "harness/program/usage_error.h"
#include "harness/scenes/saved/saved_scene.h"
#include "harness/structures/structure_under_test.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

struct BuildOptions : MakingOptions {
  std::string scene;
  std::string output;
};

void add_options(CLI::App& app, BuildOptions& o) {
  app.add_option("scene", o.scene, "A built-in scene (see list) or a file, as in --scenes")->required();
  app.add_option("-o,--output", o.output, "File.stbvh: the scene with its structure")->required();
  add_making_options(app, o);
}

void run_build(const BuildOptions& options) {
  const std::vector<std::string> scenes = named_scenes({options.scene});
  if (scenes.size() != 1) throw UsageError("build takes one scene at a time.");
  if (std::filesystem::path(options.output).extension() != ".stbvh")
    throw UsageError(fmt::format("build writes .stbvh files, not \"{}\".", options.output));
  const SceneSource source = find_scene(scenes.front(), options);
  check_writable(options.output);
  if (is_stream(options.output))
    throw UsageError(
        fmt::format("build reads what it wrote: \"{}\" must be a file, and is none.", options.output));
  Progress progress;
  progress.stage(fmt::format("{}: making the scene", source.name));
  const Scene scene = source.load();
  progress.stage(fmt::format("{}: building", source.name));
  const auto structure = build_structure("stbvh-direct", scene, 0);
  progress.stage(fmt::format("{}: writing", source.name));
  const std::string file = to_saved_file(scene, *structure->tree());
  write_file(options.output, file);
  progress.stage(fmt::format("{}: reading it again", source.name));
  const auto start = std::chrono::steady_clock::now();
  const SavedStructure saved{std::filesystem::path(options.output)};
  const auto again = saved.structure();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (again->tree_hash() != structure->tree()->tree_hash())
    throw std::runtime_error(fmt::format("\"{}\" holds another tree than was built.", options.output));
  progress.clear();
  const BuildRecord& built = structure->build_record();
  fmt::print(
      "{}: {} triangles, {:.1f} MB with their structure of {:.1f} MB; built in {:.2f} s, there again in "
      "{:.2f} s\n",
      options.output, scene.triangle_count(), static_cast<double>(file.size()) / 1e6,
      static_cast<double>(built.structure_bytes) / 1e6, built.build_s, seconds);
}

}  // namespace

Work build_command(CLI::App& app) {
  return make_work(app, run_build);
}

}  // namespace stbvh::harness
