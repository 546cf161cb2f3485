/// The rounding mode that Embree asks applications to set.
#pragma once

#include <xmmintrin.h>

namespace stbvh::test {

/// Sets flush-to-zero and denormals-are-zero while it lives, where `on`.
class FlushToZero {
 public:
  explicit FlushToZero(bool on) : before_(_mm_getcsr()) {
    if (on) _mm_setcsr(before_ | 0x8040u);
  }
  ~FlushToZero() { _mm_setcsr(before_); }
  FlushToZero(const FlushToZero&) = delete;
  FlushToZero& operator=(const FlushToZero&) = delete;

 private:
  unsigned before_;
};

}  // namespace stbvh::test
