/// Progress over an update that may be given up, and the build that follows it then.
#pragma once

#include <algorithm>
#include <utility>

namespace stbvh::plugin {

/// `progress`, told the largest fraction so far: what was done stays done.
template <typename Progress>
auto never_decreasing(Progress progress) {
  return [progress = std::move(progress), done = 0.0](double fraction) mutable {
    done = std::max(done, fraction);
    return progress(done);
  };
}

}  // namespace stbvh::plugin
