#include <fmt/format.h>

#include <cstdio>

#include "harness/cli/commands.h"
#include "harness/cli/progress.h"
#include "harness/cli/scene_source.h"
#include "harness/files/output_file.h"
#include "harness/scenes/embree_xml/writer.h"

namespace stbvh::harness {

void run_convert(const Options& options) {
  const SceneSource source = find_scenes(options).front();
  const std::filesystem::path xml_file = options.converted, binary_file = embree_binary_file(xml_file);
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
