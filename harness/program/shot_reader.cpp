#include "harness/program/shot_reader.h"

#include <fmt/format.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>
#include <vector>

#include "harness/program/interruption.h"
#include "harness/program/script.h"
#include "harness/program/unnamed_file.h"
#include "harness/scenes/shots/shot.h"

namespace stbvh::harness {
namespace {

/// To stand behind "it"; empty where the script came to its end.
std::string describe(const ScriptEnd& end) {
  if (end.signal == SIGXCPU) return "takes the library that reads it more than an hour";
  if (end.signal != 0) return fmt::format("crashes the library that reads it ({})", strsignal(end.signal));
  if (end.exit_code != 0)
    return fmt::format("cannot be read: its reader ended with exit code {} (is there room in {}?)",
                       end.exit_code, std::filesystem::temp_directory_path().string());
  return "";
}

std::unique_ptr<UnnamedFile> unnamed_file() {
  try {
    return std::make_unique<UnnamedFile>();
  } catch (const std::system_error& error) {
    throw SceneFileError(error.what());
  }
}

}  // namespace

Scene read_shot(const std::string& name, const ShotOptions& options, const SceneWarning& warn) {
  const std::unique_ptr<UnnamedFile> handover = unnamed_file();
  std::vector<std::string> arguments{"--deviation", fmt::format("{}", options.largest_deviation)};
  arguments.push_back(fmt::format("--camera-steps={}", camera_step_count(options.shutter)));
  if (options.shutter) {
    arguments.push_back(fmt::format("--shutter={},{}", options.shutter->begin, options.shutter->end));
    if (options.shutter->is_in_frames)
      arguments.push_back(fmt::format("--frame-rate={}", options.shutter->frame_rate));
  }
  arguments.insert(arguments.end(), {"--", name, std::to_string(handover->descriptor())});
  const ScriptEnd end = run_python("shots", "read_shot.py", arguments);
  if (end.signal == SIGINT) throw Interrupted(fmt::format("{} was not read.", name));
  Scene scene = load_shot(handover->path(), name, describe(end), warn);
  if (scene.meshes.empty() && !may_be_empty(options.shutter))
    throw SceneFileError(fmt::format("{}: it has no mesh that can be shown", name));
  return scene;
}

}  // namespace stbvh::harness
