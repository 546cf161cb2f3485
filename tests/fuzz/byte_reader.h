/// The fuzzer's bytes as numbers.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "stbvh/mesh_view.h"

namespace stbvh::fuzz {

/// Reads one value after another from the front; zeros once the bytes are used up.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }

  /// Any bit pattern.
  template <typename T>
  T take() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    const std::size_t count = bytes_.size() < sizeof value ? bytes_.size() : sizeof value;
    if (count > 0) std::memcpy(&value, bytes_.data(), count);
    bytes_ = bytes_.subspan(count);
    return value;
  }

  std::uint8_t byte() { return take<std::uint8_t>(); }
  /// 0 to limit - 1, from one byte.
  std::uint32_t below(std::uint32_t limit) { return byte() % limit; }
  /// True for one byte in sixteen, and never once the bytes are used up.
  bool rarely() { return byte() >= 0xF0; }

  /// Mostly small multiples of 1/16 from one byte; else a value at the edge of something, or any bit pattern.
  float number() {
    constexpr float inf = std::numeric_limits<float>::infinity();
    constexpr float kEdges[] = {-0.0f,
                                std::numeric_limits<float>::denorm_min(),
                                -std::numeric_limits<float>::denorm_min(),
                                1e-42f,
                                std::numeric_limits<float>::min(),
                                -1e-37f,
                                1e-30f,
                                1e-20f,
                                -1e-7f,
                                1.0f + std::numeric_limits<float>::epsilon(),
                                1e3f,
                                -1e6f,
                                1e10f,
                                1e17f,
                                -1.8e18f,
                                kMaxCoordinate,
                                1e30f,
                                std::numeric_limits<float>::max(),
                                -std::numeric_limits<float>::max(),
                                inf,
                                -inf,
                                std::numeric_limits<float>::quiet_NaN()};
    constexpr std::uint8_t kFirstEdge = 0xE0;
    const std::uint8_t code = byte();
    if (code < kFirstEdge) return (static_cast<float>(code) - 112.0f) / 16.0f;
    const std::size_t edge = code - kFirstEdge;
    return edge < std::size(kEdges) ? kEdges[edge] : take<float>();
  }

  /// A power of two from one byte: mostly between 1/16 and 16, else between 2^-limit and 2^limit; 1 once the
  /// bytes are used up.
  float power_of_two(int limit) {
    const int code = take<std::int8_t>();
    return std::ldexp(
        1.0f, std::abs(code) <= 80 ? code / 20 : (std::abs(code) - 80) * limit / 48 * (code > 0 ? 1 : -1));
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace stbvh::fuzz
