/// How long what was found out about a scene holds.
#pragma once

#include <atomic>
#include <cstdint>

namespace stbvh::preload {

namespace detail {
inline std::atomic<std::uint64_t> scenes_epoch{1};
}

/// Another number after each change: what was found out under this one still holds under it.
inline std::uint64_t scenes_epoch() {
  return detail::scenes_epoch.load(std::memory_order_acquire);
}

/// After anything that may change what answers for a scene.
inline void scenes_changed() {
  detail::scenes_epoch.fetch_add(1, std::memory_order_release);
}

}  // namespace stbvh::preload
