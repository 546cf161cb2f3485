/// Finds indices by what they stand for.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace stbvh {

/// A hash table from 64-bit keys to indices, open addressing; sized for `count` entries.
class IndexTable {
 public:
  explicit IndexTable(std::size_t count)
      : mask_(std::bit_ceil(std::max<std::size_t>(2 * count, 2)) - 1), slots_(mask_ + 1, kFree) {}

  /// The first index in the chain of `hash` for which `same(index)`; otherwise `added` is entered.
  template <typename Same>
  std::uint32_t find_or_add(std::uint64_t hash, std::uint32_t added, const Same& same) {
    std::size_t slot = (hash * 0x9E3779B97F4A7C15u >> 32) & mask_;
    while (slots_[slot] != kFree) {
      if (same(slots_[slot])) return slots_[slot];
      slot = (slot + 1) & mask_;
    }
    return slots_[slot] = added;
  }

 private:
  static constexpr std::uint32_t kFree = 0xFFFFFFFFu;
  std::size_t mask_;
  std::vector<std::uint32_t> slots_;
};

}  // namespace stbvh
