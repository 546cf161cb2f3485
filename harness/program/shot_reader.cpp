#include "harness/program/shot_reader.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <vector>

#include "harness/files/input_file.h"
#include "harness/program/interruption.h"
#include "harness/program/script.h"
#include "harness/program/unnamed_file.h"
#include "harness/scenes/shots/shot.h"
#include "harness/scenes/shots/usd_depth.h"

namespace stbvh::harness {
namespace {

/// What this process may take at most.
std::size_t most_memory() {
  std::size_t most =
      static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (const auto kind : {RLIMIT_AS, RLIMIT_DATA}) {
    rlimit own{};
    if (getrlimit(kind, &own) == 0) most = std::min<std::size_t>(most, own.rlim_cur);
  }
  return most;
}

/// To stand behind "it"; empty where the script came to its end.
std::string describe(const ScriptEnd& end) {
  if (end.signal == SIGXCPU) return "takes the library that reads it more than an hour";
  // Libraries crash where they get none.
  if (end.signal != 0 && end.most_bytes > most_memory() / 2) return "needs more memory than there is";
  if (end.signal != 0) return fmt::format("crashes the library that reads it ({})", strsignal(end.signal));
  if (end.exit_code != 0)
    return fmt::format("cannot be read: its reader ended with exit code {} (is there room in {}?)",
                       end.exit_code, temporary_folder());
  return "";
}

/// Before a library gets it, which would wait for a pipe and say nothing of a file that is too large or too
/// deep.
void check_file(const std::string& name) {
  try {
    const InputFile file(name, kMaxSceneFileBytes);
    if (is_nested_too_deeply(file))
      throw InputFileError(fmt::format("is nested more than {} levels deep", kMaxUsdDepth));
  } catch (const InputFileError& error) {
    throw SceneFileError(fmt::format("{}: it {}", name, error.what()));
  }
}

}  // namespace

Scene read_shot(const std::string& name, const ShotOptions& options, const SceneWarning& warn) {
  check_file(name);
  const UnnamedFile handover;
  std::vector<std::string> arguments{"--deviation", fmt::format("{}", options.largest_deviation)};
  arguments.push_back(fmt::format("--camera-steps={}", camera_step_count(options.shutter)));
  if (options.shutter) {
    arguments.push_back(fmt::format("--shutter={},{}", options.shutter->begin, options.shutter->end));
    if (options.shutter->is_in_frames)
      arguments.push_back(fmt::format("--frame-rate={}", options.shutter->frame_rate));
  }
  arguments.insert(arguments.end(), {"--", name, std::to_string(handover.descriptor())});
  const ScriptEnd end = run_python("shots", "read_shot.py", arguments);
  if (end.signal == SIGINT) throw Interrupted(fmt::format("{} was not read.", name));
  Scene scene = load_shot(handover.path(), name, describe(end), warn);
  if (scene.meshes.empty() && !may_be_empty(options.shutter))
    throw SceneFileError(fmt::format("{}: it has no mesh that can be shown", name));
  return scene;
}

}  // namespace stbvh::harness
