#include "harness/images/exr_header.h"

#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfTileDescription.h>
#include <ImfVersion.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "harness/images/exr_streams.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kFixedSize = 8;  // of the magic number and the version
constexpr std::size_t kMaxPixelBytes = std::size_t{4} << 30;
constexpr std::size_t kMaxCompression = 4096;               // zlib reaches 1032; more is a broken header
constexpr std::size_t kSmallBytes = std::size_t{64} << 20;  // that any file may ask for

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw Iex::InputExc(fmt::format(text, std::forward<Args>(args)...));
}

/// Takes values off the front of a file.
class Cursor {
 public:
  explicit Cursor(std::string_view rest) : rest_(rest) {}

  std::string_view bytes(std::size_t count) {
    if (count > rest_.size()) fail("it ends too early");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  std::string_view text() {
    const std::string_view taken = rest_.substr(0, rest_.find('\0'));
    bytes(taken.size() + 1);
    return taken;
  }
  std::uint32_t number() {
    std::uint32_t value = 0;
    for (const char c : bytes(4)) value = value >> 8 | std::uint32_t{static_cast<unsigned char>(c)} << 24;
    return value;
  }
  std::size_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
};

/// Bytes of the values of types that always have as many; nothing for others.
std::optional<std::size_t> fixed_size(std::string_view type) {
  static const std::map<std::string_view, std::size_t> kSizes{{"box2f", 16},
                                                              {"box2i", 16},
                                                              {"chromaticities", 32},
                                                              {"compression", 1},
                                                              {"deepImageState", 1},
                                                              {"double", 8},
                                                              {"envmap", 1},
                                                              {"float", 4},
                                                              {"int", 4},
                                                              {"keycode", 28},
                                                              {"lineOrder", 1},
                                                              {"m33d", 72},
                                                              {"m33f", 36},
                                                              {"m44d", 128},
                                                              {"m44f", 64},
                                                              {"rational", 8},
                                                              {"tiledesc", 9},
                                                              {"timecode", 8},
                                                              {"v2d", 16},
                                                              {"v2f", 8},
                                                              {"v2i", 8},
                                                              {"v3d", 24},
                                                              {"v3f", 12},
                                                              {"v3i", 12}};
  const auto found = kSizes.find(type);
  return found == kSizes.end() ? std::nullopt : std::optional(found->second);
}

/// Whether `value` ends where a value of its type does: OpenEXR reads on to there, and takes memory for
/// counts in it, whatever the size of the attribute is.
bool is_exact(std::string_view type, Cursor value) {
  if (const auto size = fixed_size(type)) return value.left() == *size;
  if (type == "floatvector") return value.left() % 4 == 0;
  if (type == "stringvector") {
    while (value.left() > 0) value.bytes(value.number());
  } else if (type == "chlist") {
    while (!value.text().empty()) value.bytes(16);
  } else if (type == "preview") {
    const std::uint64_t width = value.number(), height = value.number();
    return width * height == value.left() / 4 && value.left() % 4 == 0;  // of two 32-bit numbers
  } else {
    return true;  // texts, and what OpenEXR does not know
  }
  return value.left() == 0;
}

/// Throws unless OpenEXR will find each attribute where it is, and no more in it than is there. ID manifests,
/// which nothing here asks for, are packed, and OpenEXR takes memory for all that they claim: `file` gets a
/// type for them that it passes over.
void check_attributes(Cursor header, std::string& file) {
  for (std::string_view name = header.text(); !name.empty(); name = header.text()) {
    const std::string_view type = header.text();
    if (type == "idmanifest") file[static_cast<std::size_t>(type.data() - file.data())] = 'I';
    const std::uint32_t size = header.number();
    if (size > header.left())
      fail("its attribute \"{}\" should have {} bytes, but only {} are left", name, size, header.left());
    if (!is_exact(type, Cursor(header.bytes(size))))
      fail("{} bytes are not a value of its attribute \"{}\" of type {}", size, name, type);
  }
}

/// How many lines are compressed together.
std::size_t lines_of_block(Imf::Compression compression) {
  switch (compression) {
    case Imf::NO_COMPRESSION:
    case Imf::RLE_COMPRESSION:
    case Imf::ZIPS_COMPRESSION:
      return 1;
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
      return 16;
    case Imf::DWAB_COMPRESSION:
      return 256;
    default:
      return 32;
  }
}

/// The most pixels that are in memory at a time: all of them, or a row of tiles, or the lines of a block.
std::size_t pixels_in_memory(const Imf::Header& header, const PixelWindow& window) {
  if (!header.hasTileDescription())
    return window.width * std::max(window.height, lines_of_block(header.compression()));
  const Imf::TileDescription& tile = header.tileDescription();
  return std::max<std::size_t>(window.width, tile.xSize) * std::max<std::size_t>(window.height, tile.ySize);
}

void check_size(const Imf::Header& header, std::size_t file_bytes) {
  const PixelWindow window = to_window(header.dataWindow());
  std::size_t channels = 0;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) ++channels;
  if (channels == 0) fail("it has no channels");
  const std::size_t most_bytes =
      std::min(kMaxPixelBytes, std::max(kSmallBytes, kMaxCompression * file_bytes));
  if (window.width > kMaxExrSide || window.height > kMaxExrSide ||
      pixels_in_memory(header, window) > most_bytes / 4 / channels) {
    fail("{} x {} pixels of {} channels are too many for it", window.width, window.height, channels);
  }
}

}  // namespace

PixelWindow to_window(const Imath::Box2i& box) {
  const auto side = [](int first, int last) {
    return static_cast<std::size_t>(std::int64_t{last} - std::int64_t{first} + 1);
  };
  return {box.min.x, box.min.y, side(box.min.x, box.max.x), side(box.min.y, box.max.y)};
}

Imf::Header read_exr_header(std::string& file) {
  Cursor cursor(file);
  constexpr std::uint32_t kMagic = 20000630;
  if (file.size() < kFixedSize || cursor.number() != kMagic) fail("it is not an OpenEXR file");
  int version = static_cast<int>(cursor.number());
  if (Imf::isMultiPart(version)) fail("it has several parts");
  if (Imf::isNonImage(version)) fail("it is deep: its pixels have many samples");
  check_attributes(cursor, file);
  MemoryIn stream(file);
  stream.seekg(kFixedSize);
  Imf::Header header;
  header.readFrom(stream, version);
  header.sanityCheck(Imf::isTiled(version));
  check_size(header, file.size());
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
      fail("its channel \"{}\" does not have every pixel", c.name());
  }
  return header;
}

}  // namespace stbvh::harness
