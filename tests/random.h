/// Numbers for the scenes and rays of tests.
#pragma once

#include <cstdint>
#include <random>

#include "stbvh/vec.h"

namespace stbvh::test {

/// Uniform numbers, the same on every machine.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t bits() { return static_cast<std::uint32_t>(engine_()); }
  /// In [0, 1).
  float unit() { return static_cast<float>(bits() >> 8) * 0x1p-24f; }
  float between(float a, float b) { return a + (b - a) * unit(); }
  unsigned below(unsigned n) { return bits() % n; }
  /// Each coordinate in [-extent, extent).
  Vec3f point(float extent) {
    return {between(-extent, extent), between(-extent, extent), between(-extent, extent)};
  }

 private:
  std::mt19937 engine_;
};

}  // namespace stbvh::test
