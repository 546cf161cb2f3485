#include "harness/images/exr_file.h"

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfVersion.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

#include "harness/files/input_file.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSide = 65536;
constexpr std::size_t kMaxFileBytes = std::size_t{4} << 30;
constexpr std::size_t kMaxPixelBytes = std::size_t{4} << 30;
constexpr std::size_t kMaxCompression = 4096;  // zlib reaches 1032; more is a broken header

/// Where OpenEXR writes to: memory, so that the file appears whole or not at all.
class MemoryOut final : public Imf::OStream {
 public:
  MemoryOut() : OStream("memory") {}
  void write(const char bytes[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    bytes_.resize(std::max(bytes_.size(), at_ + size));
    std::memcpy(bytes_.data() + at_, bytes, size);
    at_ += size;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override { at_ = position; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// And reads from: the whole file, so that no read fails but for want of bytes.
class MemoryIn final : public Imf::IStream {
 public:
  explicit MemoryIn(std::string bytes) : IStream("memory"), bytes_(std::move(bytes)) {}
  bool read(char target[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ > bytes_.size() || bytes_.size() - at_ < size) throw Iex::InputExc("it ends too early");
    std::memcpy(target, bytes_.data() + at_, size);
    at_ += size;
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override { at_ = position; }
  std::size_t size() const { return bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// Four bytes for each pixel, row after row; `first` is the pixel at (0, 0) of the file's coordinates.
Imf::Slice slice(Imf::PixelType type, const void* first, std::size_t width) {
  return {type, static_cast<char*>(const_cast<void*>(first)), 4, 4 * width};
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
  pixels.insert(channel.name, slice(type, channel.values.data(), image.width));
}

std::string encode(const LayeredImage& image) {
  if (image.width == 0 || image.height == 0 || image.width > kMaxSide || image.height > kMaxSide ||
      image.channels.size() + image.id_channels.size() == 0) {
    throw std::invalid_argument(fmt::format("{} x {} pixels of {} channels are not an image.", image.width,
                                            image.height, image.channels.size() + image.id_channels.size()));
  }
  Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
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

/// Width and height of the data window. Throws what read_exr turns into ImageFileError.
std::pair<std::size_t, std::size_t> checked_size(const Imf::InputFile& file, std::size_t file_bytes) {
  if (Imf::isMultiPart(file.version())) throw Iex::InputExc("it has several parts");
  const Imath::Box2i& window = file.header().dataWindow();
  const auto side = [](int first, int last) {
    return static_cast<std::size_t>(std::int64_t{last} - std::int64_t{first} + 1);
  };
  const std::size_t width = side(window.min.x, window.max.x), height = side(window.min.y, window.max.y);
  const Imf::ChannelList& channels = file.header().channels();
  std::size_t count = 0;
  for (auto c = channels.begin(); c != channels.end(); ++c) ++count;
  if (count == 0) throw Iex::InputExc("it has no channels");
  const std::size_t most_bytes = std::min(kMaxPixelBytes, kMaxCompression * file_bytes);
  if (width > kMaxSide || height > kMaxSide || width * height > most_bytes / 4 / count) {
    throw Iex::InputExc(
        fmt::format("{} x {} pixels of {} channels are too many for it", width, height, count));
  }
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    if (c.channel().xSampling != 1 || c.channel().ySampling != 1) {
      throw Iex::InputExc(fmt::format("its channel \"{}\" does not have every pixel", c.name()));
    }
  }
  return {width, height};
}

LayeredImage decode(MemoryIn& stream) {
  Imf::InputFile file(stream);
  LayeredImage image;
  std::tie(image.width, image.height) = checked_size(file, stream.size());
  const std::size_t count = image.width * image.height;
  const Imf::ChannelList& channels = file.header().channels();
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    if (c.channel().type == Imf::UINT) {
      image.id_channels.push_back({c.name(), std::vector<std::uint32_t>(count)});
    } else {
      image.channels.push_back({c.name(), std::vector<float>(count)});
    }
  }
  const Imath::Box2i window = file.header().dataWindow();
  Imf::FrameBuffer pixels;
  const auto read_into = [&](Imf::PixelType type, auto& channel) {
    pixels.insert(channel.name, Imf::Slice::Make(type, channel.values.data(), window));
  };
  for (Channel& channel : image.channels) read_into(Imf::FLOAT, channel);
  for (IdChannel& channel : image.id_channels) read_into(Imf::UINT, channel);
  file.setFrameBuffer(pixels);
  file.readPixels(window.min.y, window.max.y);
  for (auto a = file.header().begin(); a != file.header().end(); ++a) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute());
    // OpenEXR itself says there what kind of part it is.
    if (text != nullptr && std::string_view(a.name()) != "type")
      image.metadata.emplace_back(a.name(), text->value());
  }
  return image;
}

}  // namespace

void write_exr(const LayeredImage& image, const fs::path& path) {
  write_file(path, encode(image));
}

LayeredImage read_exr(const fs::path& path) {
  MemoryIn stream(bytes_of(path));
  try {
    return decode(stream);
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
