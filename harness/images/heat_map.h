/// Numbers as colours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "harness/images/image.h"

namespace stbvh::harness {

/// From black over violet, red and orange to pale yellow, of ever more lightness. Below 0 as 0, above 1 as 1.
std::array<std::uint8_t, 3> heat_color(double fraction);

/// The colour of what is not finite; no heat_color is like it.
inline constexpr std::array<std::uint8_t, 3> kNotFiniteColor{0, 255, 128};

/// A picture of `values` (width * height, rows from top to bottom) with 0 as black and `largest` (above 0) as
/// the lightest colour. Below them stands the scale: all colours, with numbers from 0 to `largest` where
/// there is room. Throws std::invalid_argument for sizes that do not agree.
Image heat_map(std::span<const float> values, std::size_t width, std::size_t height, double largest);

}  // namespace stbvh::harness
