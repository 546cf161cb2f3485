#include "plugin/preload/commit_turns.h"

#include <thread>

namespace stbvh::preload {

CommitTurns::Turn::Turn(CommitTurns& turns) : turns_(turns), lock_(turns.mutex_, std::try_to_lock) {
  if (lock_.owns_lock()) return;
  const std::size_t failures_before = turns.failures_.load(std::memory_order_relaxed);
  while (!lock_.try_lock()) {
    turns.arena_.execute([&] { turns.group_.wait(); });
    std::this_thread::yield();
  }
  found_failure_ = turns.failures_.load(std::memory_order_relaxed) != failures_before;
}

}  // namespace stbvh::preload
