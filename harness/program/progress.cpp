#include "harness/program/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include "harness/program/program.h"

namespace stbvh::harness {
namespace {

constexpr std::chrono::seconds kBetweenLines{120};

}  // namespace

Progress::Progress()
    : is_terminal_(isatty(STDERR_FILENO) != 0), start_(Clock::now()), last_(start_ - kBetweenLines) {}

Progress::~Progress() {
  clear();
}

void Progress::stage(std::string_view text) {
  const Clock::time_point now = Clock::now();
  if (!is_terminal_ && now - last_ < kBetweenLines) return;
  last_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  write_to_stderr(fmt::format("{}[{:5.0f} s] {}{}", is_terminal_ ? "\r\x1b[K" : "", seconds, text,
                              is_terminal_ ? "" : "\n"));
}

void Progress::clear() {
  if (is_terminal_) write_to_stderr("\r\x1b[K");
}

}  // namespace stbvh::harness
