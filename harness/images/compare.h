/// How far a picture is from a reference.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "harness/files/user_error.h"
#include "harness/images/layered_image.h"

namespace stbvh::harness {

/// Two pictures that cannot be compared; what() is one sentence for the user.
struct ComparisonError : UserError {
  using UserError::UserError;
};

struct PixelDifference {
  std::int64_t x = 0;  ///< in the coordinates of the pictures
  std::int64_t y = 0;  ///< downwards
  std::array<float, 3> picture{};
  std::array<float, 3> reference{};
};

/// Of R, G and B, over the pixels that both pictures have, and for all figures but `differing` are finite in
/// both.
struct Comparison {
  std::size_t width = 0;  ///< of what both have
  std::size_t height = 0;
  std::int64_t left = 0;  ///< where that begins
  std::int64_t top = 0;
  std::size_t only_in_picture = 0;    ///< pixels that are not compared: the reference has none there
  std::size_t only_in_reference = 0;  ///< likewise
  std::size_t not_finite = 0;         ///< pixels that are NaN or infinite in one of them or both
  /// Pixels that are not the same. The same are: equal numbers, so zeros of either sign; any two NaNs; two
  /// infinities of one sign.
  std::size_t differing = 0;
  double rmse = 0;          ///< of linear radiance: root of the mean over pixels and channels
  double relative_mse = 0;  ///< mean of (picture - reference)^2 / (reference^2 + 0.01)
  double flip_mean = 0;     ///< of the tone mapped pictures (flip.h)
  double flip_max = 0;
  /// That differ most, by squares; the worst first, which are those finite in one only; at most kWorstPixels.
  std::vector<PixelDifference> worst{};
  std::vector<float> flip_map{};        ///< for each pixel; NaN where one of them is not finite
  std::vector<std::string> warnings{};  ///< sentences: why equal numbers may not mean equal pictures
};
inline constexpr std::size_t kWorstPixels = 5;

/// Relative MSE as in Rousselle, Knaus, Zwicker: Adaptive Sampling and Reconstruction using Greedy Error
/// Minimization, SIGGRAPH Asia 2011. Pixels are compared with those at the same place. Throws ComparisonError
/// for pictures without R, G or B, that have no place in common or no pixel that is finite in both, or that
/// each fill their display from the same corner on but differ in size: these are of different resolutions.
Comparison compare(const LayeredImage& picture, const LayeredImage& reference);

}  // namespace stbvh::harness
