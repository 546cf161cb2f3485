#include "harness/images/tone_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stbvh::harness {

float tone_mapped(float radiance) {
  constexpr float kShoulder = 0.6f;
  if (!(radiance > 0)) return 0;
  if (radiance <= kShoulder) return radiance;
  return 1.0f - (1.0f - kShoulder) * std::exp(-(radiance - kShoulder) / (1.0f - kShoulder) * 0.6f);
}

std::uint8_t srgb_byte(float fraction) {
  const float value =
      fraction <= 0.0031308f ? 12.92f * fraction : 1.055f * std::pow(fraction, 1.0f / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

Image tone_mapped(const LayeredImage& picture) {
  Image image{.width = picture.width, .height = picture.height, .rgb = {}};
  image.rgb.resize(picture.width * picture.height * 3);
  std::size_t offset = 0;
  for (const char* name : {"R", "G", "B"}) {
    const std::vector<float>* values = picture.find(name);
    if (values == nullptr) throw std::invalid_argument(fmt::format("There is no channel {}.", name));
    for (std::size_t i = 0; i < values->size(); ++i) {
      image.rgb[i * 3 + offset] = srgb_byte(tone_mapped((*values)[i]));
    }
    ++offset;
  }
  return image;
}

}  // namespace stbvh::harness
