/// Work of ours apart from the caller's.
#pragma once

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

namespace stbvh {

/// Runs `work` on its own: not cancelled with tasks of the caller, and not interrupted by them while it
/// waits.
template <typename Work>
void isolated(const Work& work) {
  tbb::task_group_context context(tbb::task_group_context::isolated);
  tbb::task_group group(context);
  group.run_and_wait([&] { tbb::this_task_arena::isolate(work); });
}

}  // namespace stbvh
