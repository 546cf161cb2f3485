#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/program/progress.h"
#include "harness/program/scene_options.h"
#include "harness/program/scene_source.h"
#include "harness/program/usage_error.h"
#include "harness/scenes/embree_xml/writer.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

struct ConvertOptions : MakingOptions {
  std::string scene;
  std::string output;
};

void add_options(CLI::App& app, ConvertOptions& o) {
  app.add_option("scene", o.scene, "A built-in scene (see list) or a file, as in --scenes")->required();
  app.add_option("-o,--output", o.output,
                 "File.xml; for a large scene, a File.bin beside it has positions and triangles")
      ->required();
  add_making_options(app, o);
}

/// The format has equidistant steps only.
void check_steps(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) {
    if (!mesh.has_step_times() && mesh.steps.size() <= kMaxSceneSteps) continue;
    throw UsageError(fmt::format(
        "Embree's XML has equidistant steps, {0} at most, and \"{1}\" has {2}{3}: --resample-steps {0} makes "
        "them.",
        kMaxSceneSteps, mesh.name, mesh.steps.size(), mesh.has_step_times() ? " at times of their own" : ""));
  }
}

/// A .bin beside the .xml may be the buffer of a glTF file, or anything: it is only replaced where it is
/// ours.
void check_owner(const std::filesystem::path& binary_file, const std::filesystem::path& xml_file) {
  std::filesystem::path gltf = xml_file;
  gltf.replace_extension(".gltf");
  std::error_code unreachable;  // check_writable() says it
  const auto exists = [&](const std::filesystem::path& file) {
    return std::filesystem::exists(file, unreachable);
  };
  if (exists(binary_file) && (!exists(xml_file) || exists(gltf))) {
    throw UsageError(
        fmt::format("\"{}\" is there already and may belong to another file; choose another name.",
                    binary_file.string()));
  }
}

void run_convert(const ConvertOptions& options) {
  const std::vector<std::string> scenes = named_scenes({options.scene});
  if (scenes.size() != 1) throw UsageError("convert takes one scene at a time.");
  const std::filesystem::path xml_file = options.output, binary_file = embree_binary_file(xml_file);
  if (xml_file.extension() != ".xml")
    throw UsageError(fmt::format("convert writes .xml files, not \"{}\".", options.output));
  const SceneSource source = find_scene(scenes.front(), options);
  check_owner(binary_file, xml_file);
  check_writable(xml_file);
  check_writable(binary_file);
  Progress progress;
  progress.stage(fmt::format("{}: making the scene", source.name));
  const Scene scene = source.load();
  check_steps(scene);
  progress.stage(fmt::format("{}: writing", source.name));
  const EmbreeXml file = to_embree_xml(scene, print_warning);
  std::vector<FileContent> files;
  if (!file.binary.empty()) files.push_back({binary_file, file.binary});
  files.push_back({xml_file, {file.xml}});
  write_files(files);
  progress.clear();
  for (const FileContent& written : files) fmt::print("{}\n", written.path.string());
}

}  // namespace

Work convert_command(CLI::App& app) {
  return make_work(app, run_convert);
}

}  // namespace stbvh::harness
