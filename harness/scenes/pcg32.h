/// Random numbers that are the same on every machine.
#pragma once

#include <cstdint>

namespace stbvh::harness {

/// PCG-XSH-RR 64/32 (O'Neill 2014): small, and the same on every machine, unlike std distributions.
class Pcg32 {
 public:
  explicit Pcg32(std::uint64_t seed, std::uint64_t stream = 0) : increment_((stream << 1) | 1) {
    next();
    state_ += seed;
    next();
  }

  std::uint32_t next() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005u + increment_;
    const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    const auto turn = static_cast<std::uint32_t>(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
  }
  /// In [0, 1).
  double uniform() { return next() * 0x1p-32; }
  double uniform(double a, double b) { return a + (b - a) * uniform(); }

 private:
  std::uint64_t state_ = 0;
  std::uint64_t increment_;
};

}  // namespace stbvh::harness
