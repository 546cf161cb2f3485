/// Threads that each stay on one core, for measurements.
#pragma once

#include <barrier>
#include <chrono>
#include <functional>
#include <thread>
#include <vector>

namespace stbvh::harness {

/// Cores that this process may use.
unsigned usable_core_count();

/// A team of threads, each pinned to a core of its own, with denormals flushed to zero as Embree asks of its
/// applications. Work must not throw.
class PinnedThreads {
 public:
  /// `count` is at least 1 and at most usable_core_count(). Throws std::system_error where the system gives
  /// no more threads.
  explicit PinnedThreads(unsigned count);
  ~PinnedThreads();
  PinnedThreads(const PinnedThreads&) = delete;
  PinnedThreads& operator=(const PinnedThreads&) = delete;

  unsigned count() const { return static_cast<unsigned>(threads_.size()); }

  /// Runs work(thread) on all threads at once; returns the seconds from the first start to the last end.
  double run(const std::function<void(unsigned thread)>& work);

 private:
  struct NotStarted {};
  PinnedThreads(unsigned count, NotStarted);

  using Clock = std::chrono::steady_clock;
  struct Times {
    Clock::time_point begin, end;
  };

  void serve(unsigned thread, int core);

  std::barrier<> start_;
  std::barrier<> finish_;
  const std::function<void(unsigned)>* work_ = nullptr;  ///< null: end
  std::vector<Times> times_;
  std::vector<std::thread> threads_;
};

}  // namespace stbvh::harness
