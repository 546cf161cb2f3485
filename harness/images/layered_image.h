/// An image of many channels in memory: what a rendering leaves, and what is compared.
#pragma once

#include <cstddef>
#include <cstdint>
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

struct LayeredImage {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<Channel> channels;
  std::vector<IdChannel> id_channels;
  std::vector<std::pair<std::string, std::string>> metadata;  ///< name and value

  /// The values of a channel; null where there is no such channel.
  const std::vector<float>* find(std::string_view name) const {
    for (const Channel& channel : channels) {
      if (channel.name == name) return &channel.values;
    }
    return nullptr;
  }
};

}  // namespace stbvh::harness
