/// An 8-bit picture in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stbvh::harness {

/// Rows from top to bottom, three sRGB bytes for each pixel.
struct Image {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::uint8_t> rgb;
};

}  // namespace stbvh::harness
