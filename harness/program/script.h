/// Programs that do parts of the work: Python scripts that draw records and read shots, ffmpeg.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace stbvh::harness {

/// A script that could not do its work; it has said why, in one line on stderr. The program ends with
/// `exit_code`.
struct ScriptFailure {
  int exit_code;
};

/// How a script or program ended.
struct ScriptEnd {
  int exit_code = 0;
  int signal = 0;              ///< that ended it; 0: none did
  std::size_t most_bytes = 0;  ///< of memory at a time
};

/// Runs the program `words[0]`, which is looked for in PATH, and waits; empty where it cannot be run. It
/// inherits what is open. Where the task group (TBB's) of the caller is cancelled it is ended:
/// SceneCancelled.
std::optional<ScriptEnd> run_program(std::vector<std::string> words);

/// Runs the script `name`, of this folder beside the program or in the data folder, with Debian's Python, and
/// waits, likewise. Throws std::runtime_error if there is no Python or no script.
ScriptEnd run_python(const std::string& folder, const std::string& name,
                     const std::vector<std::string>& arguments);

/// Runs harness/report/`name` with Debian's Python, for which Debian's matplotlib is made, and waits. Throws
/// ScriptFailure; std::runtime_error if there is no Python or a signal ended it.
void run_script(const std::string& name, const std::vector<std::string>& arguments);

}  // namespace stbvh::harness
