/// From the samples of a pixel to its numbers in the layers of an image.
#pragma once

#include <cstddef>
#include <cstdint>

#include "harness/images/layered_image.h"
#include "harness/path_tracer/path_tracer.h"

namespace stbvh::harness {

/// Sums over the samples of one pixel.
class PixelSums {
 public:
  void add(const PathSample& sample);

  std::uint64_t rays() const { return rays_; }
  std::uint64_t not_finite() const { return not_finite_; }
  /// Radiance, and what the camera's rays met in the tree.
  Color mean() const { return mean_; }
  double nodes() const { return count_ > 0 ? static_cast<double>(counters_.nodes) / count_ : 0; }
  double triangle_tests() const {
    return count_ > 0 ? static_cast<double>(counters_.triangle_tests) / count_ : 0;
  }
  /// Into the channels of `image`, made by empty_layers.
  void store(LayeredImage& image, std::size_t pixel) const;

 private:
  void add_first_hit(const PathSample& sample);

  double count_ = 0, hits_ = 0;
  Color mean_, squares_;  ///< squares_: of the distances from the mean
  Color albedo_;
  Vec3 normal_;
  double depth_ = 0, time_ = 0, motion_x_ = 0, motion_y_ = 0;
  TraversalCounters counters_;
  std::uint32_t mesh_ = kInvalidId, prim_ = kInvalidId, face_ = kInvalidId;
  std::uint64_t rays_ = 0, not_finite_ = 0;
};

/// All layers, black, nothing hit; `with_counters`: with nodes.N and triangles.N.
LayeredImage empty_layers(std::size_t width, std::size_t height, bool with_counters);

/// Bytes of each pixel of them.
std::size_t layer_bytes_per_pixel();

}  // namespace stbvh::harness
