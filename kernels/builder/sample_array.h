/// Room for something of each moment at which motion is looked at.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace stbvh {

/// `count` items, not initialised: on the stack as long as they are as few as they mostly are.
template <typename T>
class SampleArray {
 public:
  explicit SampleArray(std::size_t count) : many_(count > few_.size() ? count : 0) {}

  T* data() { return many_.empty() ? few_.data() : many_.data(); }
  T& operator[](std::size_t i) { return data()[i]; }

 private:
  std::array<T, 32> few_;
  std::vector<T> many_;
};

}  // namespace stbvh
