#include "harness/cli/script.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstdio>
#include <stdexcept>

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace stbvh::harness {

void run_script(const std::string& name, const std::vector<std::string>& arguments) {
  // -B: no compiled files beside the sources.
  std::vector<std::string> words{"/usr/bin/python3", "-B", STBVH_SOURCE_DIR "/harness/report/" + name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::fflush(stdout);
  pid_t child = 0;
  int status = 0;
  if (posix_spawn(&child, argv[0], nullptr, nullptr, argv.data(), environ) != 0 ||
      waitpid(child, &status, 0) != child || !WIFEXITED(status)) {
    throw std::runtime_error(fmt::format("{} could not be run with {}.", name, words.front()));
  }
  if (WEXITSTATUS(status) != 0) throw ScriptFailure{WEXITSTATUS(status)};
}

}  // namespace stbvh::harness
