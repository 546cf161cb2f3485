#include "harness/preview/view_composer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "harness/images/heat_map.h"
#include "harness/images/tone_map.h"

namespace stbvh::harness {
namespace {

constexpr std::uint8_t kNotCounted = 60;
constexpr std::uint32_t kExponent = 0x7F80;  // in the upper half of a float

std::uint32_t upper_half(float value) {
  return std::bit_cast<std::uint32_t>(value) >> 16;
}

}  // namespace

ViewComposer::ViewComposer() : display_(1u << 16) {
  for (std::uint32_t i = 0; i < display_.size(); ++i) {
    // The middle of the floats that share the entry, but for zero and infinity, which have their own.
    const bool has_middle = i != 0 && (i & kExponent) != kExponent;
    display_[i] = srgb_byte(tone_mapped(std::bit_cast<float>((i << 16) | (has_middle ? 0x8000u : 0u))));
  }
  for (std::size_t i = 0; i < heat_.size(); ++i) heat_[i] = heat_color(static_cast<double>(i) / 255);
}

ViewComposer::Rgb ViewComposer::color(const ShownPixel& pixel, std::size_t slot, bool has_counters,
                                      const ViewOptions& options) const {
  if (options.heat == HeatMap::kNone) {
    const auto& r = pixel.radiance[slot];
    return {display_[upper_half(r[0])], display_[upper_half(r[1])], display_[upper_half(r[2])]};
  }
  if (!has_counters) return {kNotCounted, kNotCounted, kNotCounted};
  const float met = options.heat == HeatMap::kNodes ? pixel.nodes[slot] : pixel.triangles[slot];
  const double fraction = std::clamp(static_cast<double>(met) / options.heat_largest, 0.0, 1.0);
  return heat_[static_cast<std::size_t>(255 * fraction)];
}

ViewComposer::Rgb ViewComposer::difference(const ShownPixel& pixel, const ViewOptions& options) const {
  Rgb rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    const float apart = std::fabs(pixel.radiance[0][c] - pixel.radiance[1][c]);
    rgb[c] = srgb_byte(std::min(1.0f, static_cast<float>(options.gain) * apart));
  }
  return rgb;
}

Image ViewComposer::compose(ShownPicture& picture, const ViewOptions& options) const {
  Image image{picture.width(), picture.height(), {}};
  image.rgb.resize(3 * image.width * image.height);
  const auto width = static_cast<double>(image.width);
  std::size_t columns_of_a = options.mode == ViewMode::kB ? 0 : image.width;
  if (options.mode == ViewMode::kSplit)
    columns_of_a = static_cast<std::size_t>(std::lround(width * std::clamp(options.split, 0.0, 1.0)));
  const bool is_pair = picture.slots == kSlots;
  if (!is_pair) columns_of_a = image.width;
  const bool shows_difference = options.mode == ViewMode::kDifference;
  picture.for_each_row([&](std::size_t y, std::span<const ShownPixel> row) {
    std::uint8_t* out = &image.rgb[3 * y * image.width];
    for (std::size_t x = 0; x < row.size(); ++x, out += 3) {
      const std::size_t slot = x < columns_of_a ? 0 : 1;
      Rgb rgb{};
      if (!shows_difference) {
        rgb = color(row[x], slot, picture.has_counters[slot], options);
      } else if (is_pair) {
        rgb = difference(row[x], options);
      }
      std::copy(rgb.begin(), rgb.end(), out);
    }
  });
  return image;
}

}  // namespace stbvh::harness
