/// What a window shows of a picture that grows: one value of each kind for each pixel, at any moment.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "harness/path_tracer/render_settings.h"
#include "harness/path_tracer/tiles.h"

namespace stbvh::harness {

/// Most structures that are compared in one picture: A and B.
inline constexpr std::size_t kSlots = 2;

/// Means over the samples so far, through each structure.
struct ShownPixel {
  std::array<std::array<float, 3>, kSlots> radiance{};
  std::array<float, kSlots> nodes{}, triangles{};  ///< that the camera's rays met, where the structure counts
};

/// Written by many threads and read by another: rows of tiles have locks of their own.
class ShownPicture {
 public:
  ShownPicture(std::size_t width, std::size_t height)
      : width_(width),
        height_(height),
        pixels_(width * height),
        row_locks_((height + Tiling::kSide - 1) / Tiling::kSide) {}

  std::size_t width() const { return width_; }
  std::size_t height() const { return height_; }

  /// Fills what of the square of side `side` at (x, y) lies in `tile`; the caller holds the tile's lock.
  void fill(const Tile& tile, std::size_t x, std::size_t y, std::size_t side, const ShownPixel& pixel) {
    for (std::size_t v = y; v < std::min(y + side, tile.y1); ++v) {
      for (std::size_t u = x; u < std::min(x + side, tile.x1); ++u) pixels_[v * width_ + u] = pixel;
    }
  }
  std::mutex& lock_of(const Tile& tile) { return row_locks_[tile.y0 / Tiling::kSide]; }

  /// Calls `read(y, pixels)` for all rows from top to bottom.
  template <typename Read>
  void for_each_row(const Read& read) {
    for (std::size_t y0 = 0; y0 < height_; y0 += Tiling::kSide) {
      const std::lock_guard lock(row_locks_[y0 / Tiling::kSide]);
      for (std::size_t y = y0; y < std::min(y0 + Tiling::kSide, height_); ++y) {
        read(y, std::span<const ShownPixel>(&pixels_[y * width_], width_));
      }
    }
  }

  /// Grows with each tile that is written.
  std::atomic<std::uint64_t> version{0};

  // Set before others see the picture.
  std::size_t slots = 1;                    ///< structures in it
  std::array<bool, kSlots> has_counters{};  ///< `nodes` and `triangles` mean something
  RenderSettings settings;                  ///< that it is made with

 private:
  std::size_t width_, height_;
  std::vector<ShownPixel> pixels_;
  std::vector<std::mutex> row_locks_;
};

/// Gives out pictures, and takes back those that nobody looks at any more: new memory for each would cost
/// more than the coarsest pass.
class ShownPicturePool {
 public:
  /// With anything in it.
  std::shared_ptr<ShownPicture> take(std::size_t width, std::size_t height) {
    std::unique_ptr<ShownPicture> picture;
    {
      const std::lock_guard lock(shelf_->mutex);
      picture = std::move(shelf_->picture);
    }
    if (!picture || picture->width() != width || picture->height() != height)
      picture = std::make_unique<ShownPicture>(width, height);
    return {picture.release(), [shelf = shelf_](ShownPicture* done) {
              std::unique_ptr<ShownPicture> kept(done);
              const std::lock_guard lock(shelf->mutex);
              std::swap(shelf->picture, kept);
            }};
  }

 private:
  struct Shelf {
    std::mutex mutex;
    std::unique_ptr<ShownPicture> picture;
  };
  std::shared_ptr<Shelf> shelf_ = std::make_shared<Shelf>();
};

}  // namespace stbvh::harness
