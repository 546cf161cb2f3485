/// Threads that commit one scene together.
#pragma once

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <utility>

namespace stbvh::preload {

/// One thread at a time has the turn; those that wait for it work on what the one that has it builds.
class CommitTurns {
 public:
  /// At most `thread_limit` threads build, 0: all.
  explicit CommitTurns(int thread_limit)
      : arena_(thread_limit == 0 ? tbb::task_arena::automatic : thread_limit) {}

  /// Has the turn as long as it lives.
  class Turn {
   public:
    explicit Turn(CommitTurns& turns);

    /// Whether another thread had the turn when this one came, and its work failed.
    bool found_failure() const { return found_failure_; }
    void failed() { turns_.failures_.fetch_add(1, std::memory_order_relaxed); }

    /// Runs `work`, and throws what it throws.
    template <typename Work>
    void run(Work&& work) {
      std::exception_ptr error;  // not through the task group: it could reach a thread that only helps
      turns_.arena_.execute([&] {
        turns_.group_.run_and_wait([&] {
          try {
            // Nor does the holder take what a waiting thread leaves to others, which waits for the holder.
            tbb::this_task_arena::isolate(work);
          } catch (...) {
            error = std::current_exception();
          }
        });
      });
      if (error != nullptr) std::rethrow_exception(error);
    }

   private:
    CommitTurns& turns_;
    std::unique_lock<std::mutex> lock_;
    bool found_failure_ = false;
  };

 private:
  std::mutex mutex_;
  std::atomic<std::size_t> failures_{0};
  /// An arena of its own: who builds here never picks up other work of the application meanwhile, which could
  /// wait for this very turn.
  tbb::task_arena arena_;
  tbb::task_group group_;
};

}  // namespace stbvh::preload
