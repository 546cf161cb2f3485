#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <system_error>

#include "harness/cli/commands.h"
#include "harness/program/progress.h"
#include "harness/program/scene_source.h"
#include "harness/program/usage_error.h"
#include "harness/scenes/embree_xml/writer.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

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

}  // namespace

void run_convert(const Options& options) {
  const SceneSource source = find_scenes(options).front();
  const std::filesystem::path xml_file = options.converted, binary_file = embree_binary_file(xml_file);
  check_owner(binary_file, xml_file);
  check_writable(xml_file);
  check_writable(binary_file);
  Progress progress;
  progress.stage(fmt::format("{}: making the scene", source.name));
  const Scene scene = source.load();
  progress.stage(fmt::format("{}: writing", source.name));
  const EmbreeXml file = to_embree_xml(scene, print_warning);
  std::vector<FileContent> files;
  if (!file.binary.empty()) files.push_back({binary_file, file.binary});
  files.push_back({xml_file, {file.xml}});
  write_files(files);
  progress.clear();
  for (const FileContent& written : files) fmt::print("{}\n", written.path.string());
}

}  // namespace stbvh::harness
