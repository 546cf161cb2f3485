/// How the making of a scene is stopped: by cancelling the task group (TBB's) that it runs in.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <cstddef>
#include <stdexcept>

namespace stbvh::harness {

/// What was being made is wanted no longer.
struct SceneCancelled : std::runtime_error {
  SceneCancelled() : std::runtime_error("the scene was cancelled") {}
};

/// Throws SceneCancelled where the task group around the caller is cancelled. Takes some nanoseconds: for
/// each step of a simulation, each line of a file.
inline void check_cancelled() {
  if (tbb::is_current_task_group_canceling()) throw SceneCancelled();
}

/// Calls body(i) for 0 to count - 1 on many threads. Unlike tbb::parallel_for it does not return with some of
/// them left out: throws SceneCancelled instead.
template <class Body>
void for_all(std::size_t count, const Body& body) {
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (!tbb::is_current_task_group_canceling()) body(i);
  });
  check_cancelled();
}

}  // namespace stbvh::harness
