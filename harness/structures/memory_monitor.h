/// Counts the bytes that an Embree device reports.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstddef>

namespace stbvh::harness {

/// Current and largest sum of what was reported; any thread may report.
class MemoryMonitor {
 public:
  /// Adds `bytes`, negative where memory is given back.
  void report(ssize_t bytes) {
    const ssize_t now = current_.fetch_add(bytes, std::memory_order_relaxed) + bytes;
    ssize_t peak = peak_.load(std::memory_order_relaxed);
    while (now > peak && !peak_.compare_exchange_weak(peak, now, std::memory_order_relaxed)) {
    }
  }

  std::size_t current_bytes() const { return static_cast<std::size_t>(current_.load()); }
  std::size_t peak_bytes() const { return static_cast<std::size_t>(peak_.load()); }

 private:
  std::atomic<ssize_t> current_{0};
  std::atomic<ssize_t> peak_{0};
};

}  // namespace stbvh::harness
