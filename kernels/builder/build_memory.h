/// The temporary memory of a build, counted while it lives.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "stbvh/structure.h"

namespace stbvh {

/// Counts the temporary memory of a build and tells the caller's callback.
class BuildMemory {
 public:
  struct LimitReached {};

  BuildMemory(const BuildCallbacks& callbacks, std::size_t limit) : callbacks_(callbacks), limit_(limit) {}
  /// Throws BuildCancelled if the callback refuses the bytes, LimitReached if there would be more than the
  /// limit; they are not counted then.
  void take(std::size_t bytes);
  void give_back(std::size_t bytes) noexcept;
  std::size_t current() const { return current_.load(); }
  std::size_t peak() const { return peak_.load(); }

 private:
  const BuildCallbacks& callbacks_;
  const std::size_t limit_;
  std::atomic<std::size_t> current_{0};
  std::atomic<std::size_t> peak_{0};
};

/// Counts memory that others allocate.
class CountedMemory {
 public:
  CountedMemory(BuildMemory& memory, std::size_t bytes) : memory_(memory), bytes_(bytes) {
    memory_.take(bytes);
  }
  ~CountedMemory() { memory_.give_back(bytes_); }
  CountedMemory(const CountedMemory&) = delete;
  CountedMemory& operator=(const CountedMemory&) = delete;

 private:
  BuildMemory& memory_;
  std::size_t bytes_;
};

/// An uninitialised array of plain data, counted in a BuildMemory while it lives.
template <typename T>
class TemporaryArray {
 public:
  TemporaryArray(BuildMemory& memory, std::size_t count) : memory_(memory), count_(count) {
    memory_.take(count * sizeof(T));
    data_ = static_cast<T*>(::operator new(count * sizeof(T), kAlignment, std::nothrow));
    if (data_ == nullptr) {
      memory_.give_back(count * sizeof(T));
      throw std::bad_alloc();
    }
  }
  ~TemporaryArray() {
    ::operator delete(data_, kAlignment);
    memory_.give_back(count_ * sizeof(T));
  }
  TemporaryArray(const TemporaryArray&) = delete;
  TemporaryArray& operator=(const TemporaryArray&) = delete;

  T* data() { return data_; }
  std::span<T> span() { return {data_, count_}; }

 private:
  static constexpr std::align_val_t kAlignment{64};
  BuildMemory& memory_;
  std::size_t count_;
  T* data_;
};

/// Hands out small pieces of plain data for one thread; all of it goes at once.
class Arena {
 public:
  explicit Arena(BuildMemory& memory) : memory_(memory) {}

  template <typename T>
  T* make() {
    constexpr std::size_t bytes = (sizeof(T) + kPieceAlignment - 1) / kPieceAlignment * kPieceAlignment;
    static_assert(alignof(T) <= kPieceAlignment);
    if (used_ + bytes > kChunkBytes) {
      chunks_.push_back(std::make_unique<TemporaryArray<std::byte>>(memory_, kChunkBytes));
      used_ = 0;
    }
    T* piece = new (chunks_.back()->data() + used_) T;
    used_ += bytes;
    return piece;
  }

 private:
  static constexpr std::size_t kChunkBytes = 1 << 18;
  static constexpr std::size_t kPieceAlignment = alignof(void*);
  BuildMemory& memory_;
  std::vector<std::unique_ptr<TemporaryArray<std::byte>>> chunks_;
  std::size_t used_ = kChunkBytes;
};

}  // namespace stbvh
