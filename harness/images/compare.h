/// How far a picture is from a reference.
#pragma once

#include <array>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "harness/images/layered_image.h"

namespace stbvh::harness {

/// Two pictures that cannot be compared; what() is one sentence for the user.
struct ComparisonError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct PixelDifference {
  std::size_t x = 0;  ///< from the left
  std::size_t y = 0;  ///< from the top
  std::array<float, 3> picture{};
  std::array<float, 3> reference{};
};

/// Of R, G and B, over the pixels that are finite in both pictures.
struct Comparison {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t not_finite = 0;  ///< pixels that are NaN or infinite in one of them, in no figure here
  std::size_t differing = 0;   ///< pixels that are not the same, bit by bit but for the sign of zero
  double rmse = 0;             ///< of linear radiance: root of the mean over pixels and channels
  double relative_mse = 0;     ///< mean of (picture - reference)^2 / (reference^2 + 0.01)
  double flip_mean = 0;        ///< of the tone mapped pictures (flip.h)
  double flip_max = 0;
  std::vector<PixelDifference>
      worst{};                    ///< that differ most, by squares; the worst first; at most kWorstPixels
  std::vector<float> flip_map{};  ///< for each pixel; NaN where one of them is not finite
};
inline constexpr std::size_t kWorstPixels = 5;

/// Relative MSE as in Rousselle, Knaus, Zwicker: Adaptive Sampling and Reconstruction using Greedy Error
/// Minimization, SIGGRAPH Asia 2011. Throws ComparisonError for pictures without R, G or B, of different
/// sizes, or without a pixel that is finite in both.
Comparison compare(const LayeredImage& picture, const LayeredImage& reference);

}  // namespace stbvh::harness
