#include "harness/program/shot_reader.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "harness/program/interruption.h"
#include "harness/program/script.h"
#include "harness/scenes/shots/shot.h"

namespace stbvh::harness {
namespace {

/// A file without a name: it is gone with the program, however that ends. The script inherits it.
class UnnamedFile {
 public:
  UnnamedFile() {
    std::string name = (std::filesystem::temp_directory_path() / "stbvh-shot-XXXXXX").string();
    descriptor_ = mkstemp(name.data());
    if (descriptor_ < 0)
      throw SceneFileError(
          fmt::format("\"{}\" cannot be written: {}", name, std::generic_category().message(errno)));
    unlink(name.c_str());
  }
  ~UnnamedFile() { close(descriptor_); }
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;

  int descriptor() const { return descriptor_; }
  std::filesystem::path path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

 private:
  int descriptor_;
};

/// To stand behind "it"; empty where the script came to its end.
std::string describe(const ScriptEnd& end) {
  if (end.signal == SIGXCPU) return "takes the library that reads it more than an hour";
  if (end.signal != 0) return fmt::format("crashes the library that reads it ({})", strsignal(end.signal));
  if (end.exit_code != 0)
    return fmt::format("cannot be read: its reader ended with exit code {} (is there room in {}?)",
                       end.exit_code, std::filesystem::temp_directory_path().string());
  return "";
}

}  // namespace

Scene read_shot(const std::string& name, const ShotOptions& options, const SceneWarning& warn) {
  const UnnamedFile handover;
  std::vector<std::string> arguments{"--deviation", fmt::format("{}", options.largest_deviation)};
  if (options.shutter_seconds)
    arguments.push_back(
        fmt::format("--shutter={},{}", options.shutter_seconds->first, options.shutter_seconds->second));
  arguments.insert(arguments.end(), {"--", name, std::to_string(handover.descriptor())});
  const ScriptEnd end = run_python("shots", "read_shot.py", arguments);
  if (end.signal == SIGINT) throw Interrupted(fmt::format("{} was not read.", name));
  return load_shot(handover.path(), name, describe(end), warn);
}

}  // namespace stbvh::harness
