/// The built program, run by tests.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
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

/// What cannot be done ends with one line that holds `reason`, and exit code 2.
inline void expect_refusal(const Outcome& run, const std::string& reason) {
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1) << run.out;
  EXPECT_TRUE(run.out.starts_with("stbvh-ab: ")) << run.out;
  EXPECT_NE(run.out.find(reason), std::string::npos) << run.out;
}

}  // namespace stbvh::harness
