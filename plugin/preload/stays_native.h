/// Why a triangle mesh stays with Embree.
#pragma once

#include <cstddef>

namespace stbvh::preload {

/// kNone: it does not.
enum class StaysNative {
  kNone,
  kOneStep,
  kUncommitted,
  kBuffers,
  kTimeRange,
  kTooLarge,
  kDevice,
  kLayout,
  kNoMemory
};
inline constexpr std::size_t kStaysNativeCount = 9;

/// In a few words, for statistics.
const char* describe(StaysNative reason);

}  // namespace stbvh::preload
