/// What the program is doing, on stderr.
#pragma once

#include <chrono>
#include <string_view>

namespace stbvh::harness {

/// On a terminal one line that is written over; otherwise a line for a new stage, at most one in two minutes.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void stage(std::string_view text);
  /// Takes the line off the terminal, before something else is printed.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  bool is_terminal_;
  Clock::time_point start_;
  Clock::time_point last_;
};

}  // namespace stbvh::harness
