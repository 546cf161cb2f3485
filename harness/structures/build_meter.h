/// Time and memory of a build.
#pragma once

#include <tbb/global_control.h>

#include <chrono>
#include <cstddef>
#include <optional>

namespace stbvh::harness {

/// Bytes of this process in memory now (/proc/self/statm), after giving back what the C library keeps free.
std::size_t resident_bytes();

/// Limits the build threads from construction on and measures until asked.
class BuildMeter {
 public:
  /// `threads` 0: all.
  explicit BuildMeter(unsigned threads);

  double seconds() const;
  /// Growth of the process's resident memory since construction.
  std::ptrdiff_t resident_growth() const;

 private:
  std::optional<tbb::global_control> thread_limit_;
  std::size_t resident_before_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace stbvh::harness
