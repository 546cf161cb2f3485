/// An image of many channels in memory: what a rendering leaves, and what is compared.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stbvh::harness {

/// Numbers for each pixel, rows from top to bottom. Names as in OpenEXR: "R", "albedo.G", "depth.Z".
struct Channel {
  std::string name;
  std::vector<float> values;
};

/// Likewise for whole numbers that no float holds: "primitive.id".
struct IdChannel {
  std::string name;
  std::vector<std::uint32_t> values;
};

/// A rectangle of pixels in coordinates that the pictures of a shot share; y grows downwards.
struct PixelWindow {
  std::int64_t left = 0;
  std::int64_t top = 0;
  std::size_t width = 0;
  std::size_t height = 0;

  std::int64_t right() const { return left + static_cast<std::int64_t>(width); }   ///< first that is outside
  std::int64_t bottom() const { return top + static_cast<std::int64_t>(height); }  ///< likewise
  bool operator==(const PixelWindow&) const = default;
};

/// x and y (CIE 1931) of red, green, blue and white.
using Chromaticities = std::array<float, 8>;
inline constexpr Chromaticities kRec709{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};

struct LayeredImage {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<Channel> channels;
  std::vector<IdChannel> id_channels;
  std::vector<std::pair<std::string, std::string>> metadata;  ///< name and value
  std::int64_t left = 0;                                      ///< where the first pixel is
  std::int64_t top = 0;
  std::optional<PixelWindow> display{};     ///< the frame of the shot; empty: just these pixels
  Chromaticities chromaticities = kRec709;  ///< what R, G and B mean
  float white_luminance = 0;                ///< candela per square metre of (1, 1, 1); 0: not said
  float pixel_aspect = 1;                   ///< width of a pixel over its height
  bool is_cube_map = false;                 ///< all directions on the six sides of a cube

  /// Where there are pixels.
  PixelWindow window() const { return {left, top, width, height}; }
  PixelWindow display_window() const { return display.value_or(window()); }

  /// The values of a channel; null where there is no such channel.
  const std::vector<float>* find(std::string_view name) const {
    for (const Channel& channel : channels) {
      if (channel.name == name) return &channel.values;
    }
    return nullptr;
  }
};

}  // namespace stbvh::harness
