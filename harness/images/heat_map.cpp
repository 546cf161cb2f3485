#include "harness/images/heat_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

namespace stbvh::harness {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

constexpr std::array<Rgb, 7> kAnchors{{{0, 0, 6},
                                       {58, 14, 100},
                                       {132, 28, 110},
                                       {202, 52, 80},
                                       {242, 106, 40},
                                       {250, 178, 60},
                                       {254, 250, 200}}};
constexpr Rgb kPaper{255, 255, 255};
constexpr Rgb kInk{20, 20, 20};

/// Glyphs of 3 x 5 pixels; a row of them is the bits of a digit, the left pixel the highest.
constexpr std::string_view kGlyphNames = "0123456789.e-";
constexpr std::array<std::array<std::uint8_t, 5>, 13> kGlyphs{{{7, 5, 5, 5, 7},
                                                               {2, 6, 2, 2, 7},
                                                               {7, 1, 7, 4, 7},
                                                               {7, 1, 7, 1, 7},
                                                               {5, 5, 7, 1, 1},
                                                               {7, 4, 7, 1, 7},
                                                               {7, 4, 7, 5, 7},
                                                               {7, 1, 1, 2, 2},
                                                               {7, 5, 7, 5, 7},
                                                               {7, 5, 7, 1, 7},
                                                               {0, 0, 0, 0, 2},
                                                               {0, 7, 7, 4, 7},
                                                               {0, 0, 7, 0, 0}}};
constexpr std::size_t kGlyphWidth = 4;  // with the gap behind it
constexpr std::size_t kGlyphHeight = 5;

class Canvas {
 public:
  Canvas(std::size_t width, std::size_t height)
      : image_{width, height, std::vector<std::uint8_t>(3 * width * height)} {}

  void set(std::size_t x, std::size_t y, const Rgb& color) {
    if (x < image_.width && y < image_.height)
      std::copy(color.begin(), color.end(), &image_.rgb[3 * (y * image_.width + x)]);
  }
  void fill(std::size_t x, std::size_t y, std::size_t width, std::size_t height, const Rgb& color) {
    for (std::size_t i = 0; i < width * height; ++i) set(x + i % width, y + i / width, color);
  }
  void write(std::string_view text, std::size_t x, std::size_t y, std::size_t size) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      const std::size_t glyph = kGlyphNames.find(text[i]);
      if (glyph == std::string_view::npos) continue;
      for (std::size_t row = 0; row < kGlyphHeight; ++row) {
        for (std::size_t column = 0; column < 3; ++column) {
          if ((kGlyphs[glyph][row] >> (2 - column) & 1) != 0)
            fill(x + (i * kGlyphWidth + column) * size, y + row * size, size, size, kInk);
        }
      }
    }
  }
  Image take() { return std::move(image_); }

 private:
  Image image_;
};

/// The colours, and below them as many numbers as there is room for, from the first line `top` on.
void draw_scale(Canvas& canvas, std::size_t width, std::size_t top, std::size_t size, double largest) {
  for (std::size_t x = 0; x < width; ++x) {
    const double fraction = width > 1 ? static_cast<double>(x) / static_cast<double>(width - 1) : 1;
    canvas.fill(x, top + 2 * size, 1, 5 * size, heat_color(fraction));
  }
  for (const std::size_t intervals : {4u, 2u, 1u}) {
    std::vector<std::string> labels;
    std::size_t text_width = 0;
    for (std::size_t i = 0; i <= intervals; ++i) {
      labels.push_back(
          fmt::format("{:.3g}", largest * static_cast<double>(i) / static_cast<double>(intervals)));
      text_width += (labels.back().size() + 1) * kGlyphWidth * size;
    }
    if (text_width > width) continue;
    for (std::size_t i = 0; i <= intervals; ++i) {
      const std::size_t glyphs = labels[i].size() * kGlyphWidth * size;
      const std::size_t middle = width * i / intervals;
      const std::size_t left = std::min(middle - std::min(middle, glyphs / 2), width - glyphs);
      canvas.write(labels[i], left, top + 8 * size, size);
    }
    return;
  }
}

}  // namespace

std::array<std::uint8_t, 3> heat_color(double fraction) {
  const double at = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(kAnchors.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), kAnchors.size() - 2);
  const double part = at - static_cast<double>(below);
  Rgb color{};
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = static_cast<std::uint8_t>(
        std::lround(kAnchors[below][c] * (1 - part) + kAnchors[below + 1][c] * part));
  }
  return color;
}

Image heat_map(std::span<const float> values, std::size_t width, std::size_t height, double largest) {
  if (width == 0 || height == 0 || values.size() != width * height || !(largest > 0)) {
    throw std::invalid_argument("A heat map needs a value for each pixel and a scale above zero.");
  }
  const std::size_t size = std::max<std::size_t>(1, width / 160);
  Canvas canvas(width, height + (8 + kGlyphHeight + 1) * size);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = static_cast<double>(values[i]);
    canvas.set(i % width, i / width, std::isfinite(value) ? heat_color(value / largest) : kNotFiniteColor);
  }
  canvas.fill(0, height, width, (8 + kGlyphHeight + 1) * size, kPaper);
  draw_scale(canvas, width, height, size, largest);
  return canvas.take();
}

}  // namespace stbvh::harness
