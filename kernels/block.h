/// The memory that nodes and leaves live in.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <new>
#include <utility>

#include "stbvh/structure.h"

namespace stbvh {

/// From the caller's allocator or our own.
class Block {
 public:
  Block(const BuildCallbacks& callbacks, std::size_t bytes) : release_(callbacks.release), bytes_(bytes) {
    if (bytes == 0) return;
    if (callbacks.allocate) {
      data_ = static_cast<std::byte*>(callbacks.allocate(bytes));
    } else {
      data_ = static_cast<std::byte*>(::operator new(bytes, kAlignment));
      release_ = [](void* data, std::size_t) { ::operator delete(data, kAlignment); };
    }
    advise_huge_pages();
  }
  /// Memory that is there, aligned to 64, given back by `release`.
  Block(std::byte* data, std::size_t bytes, std::function<void(void*, std::size_t)> release)
      : release_(std::move(release)), bytes_(bytes), data_(data) {}
  Block(Block&& other) noexcept
      : release_(std::move(other.release_)),
        bytes_(other.bytes_),
        data_(std::exchange(other.data_, nullptr)) {}
  ~Block() {
    if (data_ != nullptr && release_) release_(data_, bytes_);
  }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;

  std::byte* data() const { return data_; }
  std::size_t bytes() const { return bytes_; }

  /// Becomes as large as `bytes`; the first `kept` of them stay what they are.
  void grow(const BuildCallbacks& callbacks, std::size_t bytes, std::size_t kept) {
    Block larger(callbacks, bytes);
    std::memcpy(larger.data_, data_, kept);
    std::swap(release_, larger.release_);
    std::swap(bytes_, larger.bytes_);
    std::swap(data_, larger.data_);
  }

 private:
  /// Traversal jumps through the whole block: fewer, larger pages spare it most misses of the TLB. Advice
  /// only.
  void advise_huge_pages() {
    constexpr std::uintptr_t page = 2u << 20;
    const std::uintptr_t begin = (reinterpret_cast<std::uintptr_t>(data_) + page - 1) / page * page;
    const std::uintptr_t end = (reinterpret_cast<std::uintptr_t>(data_) + bytes_) / page * page;
    if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  }

  static constexpr std::align_val_t kAlignment{64};
  std::function<void(void*, std::size_t)> release_;
  std::size_t bytes_;
  std::byte* data_ = nullptr;
};

}  // namespace stbvh
