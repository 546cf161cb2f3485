#include "harness/program/script.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "harness/scenes/cancellation.h"
#include "plugin/files/open_file.h"

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

/// From the folder of the program: where scripts lie when it is installed, and in the build.
constexpr const char* kScriptFolders[] = {STBVH_DATA_FOLDER "/stbvh", "."};

std::string find_script(const std::string& own_folder, const std::string& name) {
  const fs::path program_folder = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* folder : kScriptFolders) {
    const fs::path script = (program_folder / folder / own_folder / name).lexically_normal();
    std::error_code ignored;
    if (fs::exists(script, ignored)) return script.string();
  }
  throw std::runtime_error(
      fmt::format("{} is not there: it belongs into {}.", name,
                  (program_folder / kScriptFolders[0] / own_folder).lexically_normal().string()));
}

/// Python prints many lines where it cannot open what it needs.
bool can_open(int files) {
  if (files == 0) return true;
  const OpenFile one("/", O_PATH);
  return one.is_open() && can_open(files - 1);
}

/// How `child` ends. Where the caller's work is cancelled it is ended: SceneCancelled.
ScriptEnd end_of(pid_t child) {
  constexpr std::chrono::milliseconds kWait{10};
  for (int status = 0;; std::this_thread::sleep_for(kWait)) {
    rusage used{};
    const pid_t ended = wait4(child, &status, WNOHANG, &used);
    if (ended == child) {
      return {.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 0,
              .signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
              .most_bytes = static_cast<std::size_t>(used.ru_maxrss) * 1024};
    }
    if (ended < 0) throw std::system_error(errno, std::generic_category(), "wait4");
    if (!tbb::is_current_task_group_canceling()) continue;
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    throw SceneCancelled();
  }
}

/// As run_program(), with the signals `blocked` blocked in it.
std::optional<ScriptEnd> run(std::vector<std::string> words, const sigset_t& blocked) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::fflush(stdout);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &blocked);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int error = posix_spawnp(&child, argv[0], nullptr, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) return std::nullopt;
  return end_of(child);
}

}  // namespace

std::optional<ScriptEnd> run_program(std::vector<std::string> words) {
  sigset_t none;
  sigemptyset(&none);
  return run(std::move(words), none);
}

ScriptEnd run_python(const std::string& folder, const std::string& name,
                     const std::vector<std::string>& arguments) {
  constexpr int kOpenFiles = 16;
  if (!can_open(kOpenFiles))
    throw std::runtime_error(
        fmt::format("{} needs {} open files, and fewer are left (ulimit -n).", name, kOpenFiles));
  // -B: no compiled files beside the sources.
  std::vector<std::string> words{"/usr/bin/python3", "-B", find_script(folder, name)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  // Ctrl-C waits until the script takes it, in record_files.py or read_shot.py: while Python starts, it would
  // print where it was.
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGINT);
  const std::optional<ScriptEnd> end = run(words, blocked);
  if (!end) throw std::runtime_error(fmt::format("{} could not be run with {}.", name, words.front()));
  return *end;
}

void run_script(const std::string& name, const std::vector<std::string>& arguments) {
  const ScriptEnd end = run_python("report", name, arguments);
  if (end.signal != 0)
    throw std::runtime_error(fmt::format("{} was ended by a signal: {}.", name, strsignal(end.signal)));
  if (end.exit_code != 0) throw ScriptFailure{end.exit_code};
}

}  // namespace stbvh::harness
