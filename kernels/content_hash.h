/// Hashes of what buffers hold: XXH3, 128 bits.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>

#include "stbvh/mesh_fingerprint.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace stbvh {

inline ContentHash to_content_hash(const XXH128_hash_t& hash) {
  return {hash.low64, hash.high64};
}

inline ContentHash hash_of(std::span<const std::byte> bytes) {
  return to_content_hash(XXH3_128bits(bytes.data(), bytes.size()));
}

/// Of bytes that come in pieces: the same as of all of them in one.
class ContentHasher {
 public:
  ContentHasher() { XXH3_128bits_reset(&state_); }

  void add(std::span<const std::byte> bytes) { XXH3_128bits_update(&state_, bytes.data(), bytes.size()); }
  ContentHash hash() const { return to_content_hash(XXH3_128bits_digest(&state_)); }

 private:
  XXH3_state_t state_;
};

inline constexpr std::size_t kElementBytes = 12;  ///< of a vertex, and of a triangle's indices

/// Calls `use` with the `count` elements of a buffer, `stride` bytes apart, side by side, in pieces; what
/// lies between them does not count.
template <typename Use>
void for_each_piece(const void* data, std::size_t count, std::size_t stride, const Use& use) {
  const auto* const bytes = static_cast<const std::byte*>(data);
  if (stride == kElementBytes) return use(std::span(bytes, count * kElementBytes));
  constexpr std::size_t kGathered = 512;
  std::array<std::byte, kGathered * kElementBytes> gathered;
  for (std::size_t first = 0; first < count; first += kGathered) {
    const std::size_t some = std::min(kGathered, count - first);
    for (std::size_t i = 0; i < some; ++i)
      std::memcpy(gathered.data() + i * kElementBytes, bytes + (first + i) * stride, kElementBytes);
    use(std::span<const std::byte>(gathered).first(some * kElementBytes));
  }
}

}  // namespace stbvh
