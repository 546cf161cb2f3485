/// An X server without a screen, for tests of windows.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace stbvh::harness {

/// Variables of the environment, in the words of env, that a program with a window runs in. Under the address
/// sanitizer Mesa's driver stays in memory until the end: unloaded, its leaks would have no name, and
/// tests/lsan.supp could not tell them from ours.
inline std::string preview_environment() {
#ifdef __SANITIZE_ADDRESS__
  const char* const driver = "/usr/lib/x86_64-linux-gnu/dri/swrast_dri.so";
  if (!std::filesystem::exists(driver)) return "";
  return std::string(" ASAN_OPTIONS=verify_asan_link_order=0 LSAN_OPTIONS=suppressions=" STBVH_SOURCE_DIR
                     "/tests/lsan.supp LD_PRELOAD=") +
         driver;
#else
  return "";
#endif
}

/// Runs Xvfb (of Debian's xvfb) as long as it lives.
class XServer {
 public:
  explicit XServer(const std::vector<std::string>& arguments = {}) {
    int numbers[2];
    if (pipe(numbers) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      dup2(numbers[1], STDOUT_FILENO);
      close(numbers[0]);
      std::vector<std::string> words{"Xvfb", "-displayfd",  "1",         "-screen",
                                     "0",    "1280x800x24", "-nolisten", "tcp"};
      words.insert(words.end(), arguments.begin(), arguments.end());
      std::vector<char*> argv;
      for (std::string& word : words) argv.push_back(word.data());
      argv.push_back(nullptr);
      if (freopen("/dev/null", "w", stderr) == nullptr) _exit(127);
      execvp("Xvfb", argv.data());
      _exit(127);
    }
    close(numbers[1]);
    char c = 0;
    while (read(numbers[0], &c, 1) == 1 && c != '\n') display_ += c;
    close(numbers[0]);
    if (!display_.empty()) display_ = ":" + display_;
  }
  ~XServer() {
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;

  /// ":7"; empty: there is no Xvfb.
  const std::string& display() const { return display_; }

 private:
  pid_t process_ = -1;
  std::string display_;
};

}  // namespace stbvh::harness
