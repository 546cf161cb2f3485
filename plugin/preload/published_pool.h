/// Where lies what the groups show to Embree.
#pragma once

#include <cstddef>

namespace stbvh::preload {

inline constexpr std::size_t kPublishedCellBytes = 192;

/// Memory within a range of addresses of its own, by which a user geometry of ours is told from the
/// application's: nothing is known of the application's user data but its value. Throws std::bad_alloc where
/// more than 131,072 are alive.
void* allocate_published();
void release_published(void* cell) noexcept;

/// Whether the address is in that range.
bool is_in_published_pool(const void* address);

/// For std::allocate_shared.
template <typename T>
struct PublishedAllocator {
  using value_type = T;
  PublishedAllocator() = default;
  template <typename Other>
  explicit PublishedAllocator(const PublishedAllocator<Other>&) {}

  T* allocate(std::size_t) {
    static_assert(sizeof(T) <= kPublishedCellBytes && alignof(T) <= 64);
    return static_cast<T*>(allocate_published());
  }
  void deallocate(T* cell, std::size_t) noexcept { release_published(cell); }
  bool operator==(const PublishedAllocator&) const { return true; }
};

}  // namespace stbvh::preload
