/// The Python scripts that draw records.
#pragma once

#include <string>
#include <vector>

namespace stbvh::harness {

/// A script that could not do its work; it has said why, in one line on stderr. The program ends with
/// `exit_code`.
struct ScriptFailure {
  int exit_code;
};

/// Runs harness/report/`name` with Debian's Python, for which Debian's matplotlib is made, and waits. Throws
/// ScriptFailure; std::runtime_error if there is no Python or a signal ended it.
void run_script(const std::string& name, const std::vector<std::string>& arguments);

}  // namespace stbvh::harness
