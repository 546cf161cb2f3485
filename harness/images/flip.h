/// How different two pictures look to a person who flips between them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace stbvh::harness {

/// What a display shows: linear fractions of its light, 0 to 1, rows from top to bottom.
struct DisplayedPicture {
  std::size_t width = 0;
  std::size_t height = 0;
  std::array<std::vector<float>, 3> rgb;  ///< sRGB primaries
};

/// Pixels in a degree of the eye: a 0.7 m wide display of 3840 pixels, seen from 0.7 m.
inline constexpr double kFlipPixelsPerDegree = 67.02064;

/// LDR-FLIP (Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild: FLIP: A Difference Evaluator
/// for Alternating Images, HPG 2020): 0 (the same) to 1 for each pixel, symmetric in its arguments. Throws
/// std::invalid_argument for pictures that are empty or differ in size.
std::vector<float> flip(const DisplayedPicture& a, const DisplayedPicture& b,
                        double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace stbvh::harness
