/// How long what was found out about a scene holds.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <utility>

#include "plugin/embree_api.h"

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

/// What a thread found out about scenes, for as long as it holds: quick where it asks of the same ones again.
template <typename Answer>
class SceneAnswers {
 public:
  /// What `find` returned when it was last called for the scene.
  template <typename Find>
  Answer of(RTCScene scene, Find&& find) {
    const auto hash = reinterpret_cast<std::uintptr_t>(scene) * std::uintptr_t{0x9E3779B97F4A7C15};
    Entry& entry = entries_[hash >> (64 - kBits)];
    const std::uint64_t epoch = scenes_epoch();
    if (entry.scene != scene || entry.epoch != epoch) entry = {scene, epoch, std::forward<Find>(find)()};
    return entry.answer;
  }

 private:
  struct Entry {
    RTCScene scene = nullptr;
    std::uint64_t epoch = 0;
    Answer answer{};
  };
  static constexpr unsigned kBits = 6;  // for threads that trace many scenes in turns
  std::array<Entry, 1u << kBits> entries_;
};

}  // namespace stbvh::preload
