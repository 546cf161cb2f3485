/// A picture in squares that threads take one by one.
#pragma once

#include <algorithm>
#include <cstddef>

namespace stbvh::harness {

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct Tile {
  std::size_t x0, y0, x1, y1;
};

/// Tiles row by row; those at the right and lower edge may be smaller.
class Tiling {
 public:
  static constexpr std::size_t kSide = 16;

  Tiling(std::size_t width, std::size_t height)
      : width_(width), height_(height), columns_((width + kSide - 1) / kSide) {}

  std::size_t rows() const { return (height_ + kSide - 1) / kSide; }
  std::size_t count() const { return columns_ * rows(); }
  std::size_t row_of(std::size_t tile) const { return tile / columns_; }
  Tile operator[](std::size_t tile) const {
    const std::size_t x = tile % columns_ * kSide, y = tile / columns_ * kSide;
    return {x, y, std::min(x + kSide, width_), std::min(y + kSide, height_)};
  }

 private:
  std::size_t width_, height_, columns_;
};

}  // namespace stbvh::harness
