/// Numbers for the scenes and rays of tests.
#pragma once

#include <cstdint>
#include <random>

namespace stbvh::test {

/// Uniform numbers, the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// In [0, 1).
  float unit() { return static_cast<float>(engine_() >> 40) * 0x1p-24f; }
  float between(float a, float b) { return a + (b - a) * unit(); }
  unsigned below(unsigned n) { return static_cast<unsigned>(engine_() % n); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace stbvh::test
