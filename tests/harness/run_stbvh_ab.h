/// The built program, run by tests.
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace stbvh::harness {

struct Outcome {
  int exit_code;
  std::string out;  ///< stdout and stderr
};

/// Runs a command of the shell.
inline Outcome run_command(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  Outcome run{-1, ""};
  char buffer[4096];
  while (const std::size_t n = fread(buffer, 1, sizeof(buffer), pipe)) run.out.append(buffer, n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  return run;
}

/// Runs the built program.
inline Outcome stbvh_ab(const std::string& arguments) {
  return run_command(std::string(STBVH_AB) + " " + arguments + " 2>&1");
}

}  // namespace stbvh::harness
