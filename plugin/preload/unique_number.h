/// Numbers that tell versions and objects apart.
#pragma once

#include <atomic>
#include <cstdint>

namespace stbvh::preload {

/// A number that no call returned before.
inline std::uint64_t unique_number() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

}  // namespace stbvh::preload
