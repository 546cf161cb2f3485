/// From radiance to what a display shows.
#pragma once

#include <cstdint>

#include "harness/images/image.h"
#include "harness/images/layered_image.h"

namespace stbvh::harness {

/// Linear radiance as the fraction of a display's light, 0 to 1: itself up to 0.6, above that rolled off
/// instead of cut. Below zero, and NaN: 0.
float tone_mapped(float radiance);

/// The sRGB byte of a fraction of a display's light (IEC 61966-2-1).
std::uint8_t srgb_byte(float fraction);

/// The channels R, G and B as a display shows them. Throws std::invalid_argument if one is missing.
Image tone_mapped(const LayeredImage& picture);

}  // namespace stbvh::harness
