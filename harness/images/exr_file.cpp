#include "harness/images/exr_file.h"

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfEnvmapAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

#include "harness/files/input_file.h"
#include "harness/images/exr_header.h"
#include "harness/images/exr_streams.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFileBytes = std::size_t{4} << 30;

Imath::Box2i to_box(const PixelWindow& w) {
  const auto corner = [](std::int64_t x, std::int64_t y) {
    return Imath::V2i(static_cast<int>(x), static_cast<int>(y));
  };
  return {corner(w.left, w.top), corner(w.right() - 1, w.bottom() - 1)};
}

Imf::Chromaticities to_exr(const Chromaticities& c) {
  return {{c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}};
}

Chromaticities from_exr(const Imf::Chromaticities& c) {
  return {c.red.x, c.red.y, c.green.x, c.green.y, c.blue.x, c.blue.y, c.white.x, c.white.y};
}

template <typename AnyChannel>
void add_channel(const LayeredImage& image, const AnyChannel& channel, Imf::PixelType type,
                 Imf::Header& header, Imf::FrameBuffer& pixels) {
  if (channel.name.empty() || channel.values.size() != image.width * image.height ||
      header.channels().findChannel(channel.name) != nullptr) {
    throw std::invalid_argument(
        fmt::format("The channel \"{}\" of {} values does not fit into {} x {} pixels.", channel.name,
                    channel.values.size(), image.width, image.height));
  }
  header.channels().insert(channel.name, Imf::Channel(type));
  pixels.insert(channel.name, Imf::Slice::Make(type, channel.values.data(), header.dataWindow()));
}

std::string encode(const LayeredImage& image) {
  if (image.width == 0 || image.height == 0 || image.width > kMaxExrSide || image.height > kMaxExrSide ||
      image.channels.size() + image.id_channels.size() == 0) {
    throw std::invalid_argument(fmt::format("{} x {} pixels of {} channels are not an image.", image.width,
                                            image.height, image.channels.size() + image.id_channels.size()));
  }
  Imf::Header header(to_box(image.display_window()), to_box(image.window()), image.pixel_aspect);
  if (image.is_cube_map) Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
  if (image.chromaticities != kRec709) Imf::addChromaticities(header, to_exr(image.chromaticities));
  if (image.white_luminance != 0) Imf::addWhiteLuminance(header, image.white_luminance);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer pixels;
  for (const Channel& channel : image.channels) add_channel(image, channel, Imf::FLOAT, header, pixels);
  for (const IdChannel& channel : image.id_channels) add_channel(image, channel, Imf::UINT, header, pixels);
  for (const auto& [name, value] : image.metadata) {
    if (name.empty() || header.find(name) != header.end()) {
      throw std::invalid_argument(fmt::format("The metadata \"{}\" cannot be named so.", name));
    }
    header.insert(name, Imf::StringAttribute(value));
  }
  MemoryOut stream;
  {
    Imf::OutputFile file(stream, header);  // complete when it is destroyed
    file.setFrameBuffer(pixels);
    file.writePixels(static_cast<int>(image.height));
  }
  return stream.bytes();
}

[[noreturn]] void refuse(const fs::path& path, std::string_view reason) {
  throw ImageFileError(fmt::format("Cannot read the picture \"{}\": {}.", path.string(), reason));
}

std::string bytes_of(const fs::path& path) {
  try {
    return read_whole_file(path, kMaxFileBytes);
  } catch (const InputFileError& e) {
    refuse(path, fmt::format("it {}", e.what()));
  }
}

/// What the header says of the picture as a whole.
LayeredImage without_pixels(const Imf::Header& header) {
  const PixelWindow window = to_window(header.dataWindow());
  LayeredImage image;
  image.width = window.width;
  image.height = window.height;
  image.left = window.left;
  image.top = window.top;
  image.display = to_window(header.displayWindow());
  image.pixel_aspect = header.pixelAspectRatio();
  if (Imf::hasChromaticities(header)) image.chromaticities = from_exr(Imf::chromaticities(header));
  if (Imf::hasWhiteLuminance(header)) image.white_luminance = Imf::whiteLuminance(header);
  image.is_cube_map = Imf::hasEnvmap(header) && Imf::envmap(header) == Imf::ENVMAP_CUBE;
  for (auto a = header.begin(); a != header.end(); ++a) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute());
    // OpenEXR itself says there what kind of part it is.
    if (text != nullptr && std::string_view(a.name()) != "type")
      image.metadata.emplace_back(a.name(), text->value());
  }
  return image;
}

LayeredImage decode(std::string& bytes) {
  LayeredImage image = without_pixels(read_exr_header(bytes));
  MemoryIn stream(bytes);
  Imf::InputFile file(stream);
  const std::size_t count = image.width * image.height;
  const Imf::ChannelList& channels = file.header().channels();
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    if (c.channel().type == Imf::UINT) {
      image.id_channels.push_back({c.name(), std::vector<std::uint32_t>(count)});
    } else {
      image.channels.push_back({c.name(), std::vector<float>(count)});
    }
  }
  const Imath::Box2i& box = file.header().dataWindow();
  Imf::FrameBuffer pixels;
  const auto read_into = [&](Imf::PixelType type, auto& channel) {
    pixels.insert(channel.name, Imf::Slice::Make(type, channel.values.data(), box));
  };
  for (Channel& channel : image.channels) read_into(Imf::FLOAT, channel);
  for (IdChannel& channel : image.id_channels) read_into(Imf::UINT, channel);
  file.setFrameBuffer(pixels);
  file.readPixels(box.min.y, box.max.y);
  return image;
}

}  // namespace

void write_exr(const LayeredImage& image, const fs::path& path) {
  write_file(path, encode(image));
}

LayeredImage read_exr(const fs::path& path) {
  std::string bytes = bytes_of(path);
  try {
    return decode(bytes);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    std::string reason = e.what();  // OpenEXR's sentences end, and are of several lines
    reason.erase(std::remove(reason.begin(), reason.end(), '\n'), reason.end());
    while (!reason.empty() && reason.back() == '.') reason.pop_back();
    refuse(path, reason);
  }
}

}  // namespace stbvh::harness
