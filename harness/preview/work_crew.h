/// Threads that render: of low priority, so that whoever shows the picture goes first.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace stbvh::harness {

/// How far the priorities of background threads are lowered (nice). Scenes are built before pictures, and
/// both only with what the window leaves.
inline constexpr int kBuilderNiceness = 5;
inline constexpr int kRendererNiceness = 10;

/// Lowers the priority of the calling thread, and of the threads that it will start.
void lower_priority(int niceness);

/// Seconds of processor time that the calling thread has had.
double thread_seconds();

class WorkCrew {
 public:
  /// `threads` (at least 1), the one that calls run() among them. Throws std::system_error where the system
  /// gives no more threads.
  explicit WorkCrew(std::size_t threads);
  ~WorkCrew();
  WorkCrew(const WorkCrew&) = delete;
  WorkCrew& operator=(const WorkCrew&) = delete;

  std::size_t threads() const { return helpers_.size() + 1; }

  /// Calls `work` for 0 to `count` - 1, each once, in about that order; returns when all are done. From one
  /// thread at a time. `work` does not throw.
  void run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  WorkCrew() = default;
  void help();
  void take(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable begun_, ended_;
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::size_t next_ = 0, count_ = 0, busy_ = 0;
  bool quit_ = false;
  std::vector<std::thread> helpers_;
};

}  // namespace stbvh::harness
