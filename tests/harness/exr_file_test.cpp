/// OpenEXR files: what is written is read again; broken ones are refused.
#include "harness/images/exr_file.h"

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "plugin/files/output_file.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

class ExrFile : public TemporaryFolderTest {
 protected:
  void write_bytes(const std::string& bytes) const { write("image.exr", bytes); }

  const fs::path file_ = folder / "image.exr";
};

/// Values that a conversion to half, to 8 bits, or of rows and columns would change.
LayeredImage example() {
  LayeredImage image{.width = 3, .height = 2, .channels = {}, .id_channels = {}, .metadata = {}};
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  image.channels.push_back({"R", {0.1f, 1e30f, -0.0f, 1e-40f, -inf, 7.0f}});
  image.channels.push_back({"albedo.G", {1, 2, 3, 4, 5, 6}});
  image.channels.push_back({"depth.Z", {inf, nan, 3.25f, 1, 1, 1}});
  image.id_channels.push_back({"primitive.id", {0, 0xFFFFFFFFu, 16777217, 3, 4, 5}});
  image.metadata = {{"commit", "abc"}, {"scene", "crowd, \"of\" ünïcode\nand lines"}};
  return image;
}

TEST_F(ExrFile, HoldsEveryBit) {
  const LayeredImage image = example();
  write_exr(image, file_);
  const LayeredImage read = read_exr(file_);
  EXPECT_EQ(read.width, 3u);
  EXPECT_EQ(read.height, 2u);
  ASSERT_EQ(read.channels.size(), image.channels.size());
  for (const Channel& channel : image.channels) {
    const std::vector<float>* values = read.find(channel.name);
    ASSERT_NE(values, nullptr) << channel.name;
    EXPECT_EQ(std::memcmp(values->data(), channel.values.data(), 6 * sizeof(float)), 0) << channel.name;
  }
  ASSERT_EQ(read.id_channels.size(), 1u);
  EXPECT_EQ(read.id_channels[0].name, "primitive.id");
  EXPECT_EQ(read.id_channels[0].values, image.id_channels[0].values);
  EXPECT_EQ(read.metadata, image.metadata);
}

TEST_F(ExrFile, OfHalvesAwayFromTheOriginIsRead) {
  const Imath::Box2i window({-5, 7}, {-4, 7});
  Imf::Header header(window, window);
  header.channels().insert("Y", Imf::Channel(Imf::HALF));
  const half values[2] = {half(0.5f), half(-2.0f)};
  Imf::FrameBuffer pixels;
  pixels.insert("Y", Imf::Slice::Make(Imf::HALF, values, window));
  {
    Imf::OutputFile file(file_.c_str(), header);
    file.setFrameBuffer(pixels);
    file.writePixels(1);
  }
  const LayeredImage read = read_exr(file_);
  ASSERT_NE(read.find("Y"), nullptr);
  EXPECT_EQ(*read.find("Y"), (std::vector<float>{0.5f, -2.0f}));
}

TEST_F(ExrFile, KeepsWhereItsPixelsAreAndWhatTheyMean) {
  LayeredImage image = example();
  image.left = -7;
  image.top = 3;
  image.display = PixelWindow{-10, 0, 1920, 1080};
  image.pixel_aspect = 2;
  image.white_luminance = 100;
  image.chromaticities = {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
  write_exr(image, file_);
  const LayeredImage read = read_exr(file_);
  EXPECT_EQ(read.window(), image.window());
  EXPECT_EQ(read.display_window(), image.display_window());
  EXPECT_EQ(read.pixel_aspect, 2);
  EXPECT_EQ(read.white_luminance, 100);
  EXPECT_EQ(read.chromaticities, image.chromaticities);
  ASSERT_NE(read.find("R"), nullptr);
  EXPECT_EQ((*read.find("R"))[5], 7);
  write_exr(example(), file_);
  EXPECT_EQ(read_exr(file_).display_window(), (PixelWindow{0, 0, 3, 2}));
  EXPECT_EQ(read_exr(file_).chromaticities, kRec709);
}

Imf::Header header_of(int width, int height, Imf::PixelType type = Imf::FLOAT) {
  Imf::Header header(width, height);
  header.channels().insert("R", Imf::Channel(type));
  return header;
}

TEST_F(ExrFile, OfTilesIsReadAtItsFinestLevel) {
  for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS}) {
    Imf::Header header = header_of(5, 3);
    header.setTileDescription(Imf::TileDescription(2, 2, mode));
    std::vector<float> values(15);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
    {
      Imf::TiledOutputFile file(file_.c_str(), header);
      for (int x = 0; x < file.numXLevels(); ++x) {
        for (int y = 0; y < file.numYLevels(); ++y) {
          if (!file.isValidLevel(x, y)) continue;
          Imf::FrameBuffer pixels;
          pixels.insert("R", Imf::Slice::Make(Imf::FLOAT, values.data(), file.dataWindowForLevel(x, y)));
          file.setFrameBuffer(pixels);
          file.writeTiles(0, file.numXTiles(x) - 1, 0, file.numYTiles(y) - 1, x, y);
        }
      }
    }
    const LayeredImage read = read_exr(file_);
    ASSERT_NE(read.find("R"), nullptr);
    EXPECT_EQ(*read.find("R"), values) << mode;
  }
}

TEST_F(ExrFile, ThatIsACubeMapSaysSo) {
  LayeredImage image = example();
  write_exr(image, file_);
  EXPECT_FALSE(read_exr(file_).is_cube_map);
  image.is_cube_map = true;
  write_exr(image, file_);
  EXPECT_TRUE(read_exr(file_).is_cube_map);
}

std::string refusal_of(const fs::path& file) {
  try {
    read_exr(file);
  } catch (const ImageFileError& e) {
    return e.what();
  }
  return "";
}

TEST_F(ExrFile, OfSeveralPartsOrDeepOnesIsRefusedByName) {
  Imf::Header part = header_of(1, 1);
  part.setName("first");
  part.setType(Imf::SCANLINEIMAGE);
  std::vector<Imf::Header> parts{part, part};
  parts[1].setName("second");
  const float value = 1;
  {
    Imf::MultiPartOutputFile file(file_.c_str(), parts.data(), 2);
    for (int i = 0; i < 2; ++i) {
      Imf::OutputPart output(file, i);
      Imf::FrameBuffer pixels;
      pixels.insert("R", Imf::Slice::Make(Imf::FLOAT, &value, part.dataWindow()));
      output.setFrameBuffer(pixels);
      output.writePixels(1);
    }
  }
  EXPECT_NE(refusal_of(file_).find("it has several parts"), std::string::npos) << refusal_of(file_);
  Imf::Header deep = header_of(1, 1);
  deep.setType(Imf::DEEPSCANLINE);
  deep.compression() = Imf::ZIPS_COMPRESSION;
  unsigned count = 1;
  const float* samples = &value;
  {
    Imf::DeepScanLineOutputFile file(file_.c_str(), deep);
    Imf::DeepFrameBuffer pixels;
    pixels.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(&count), 4, 4));
    pixels.insert("R", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(&samples), 8, 8, 4));
    file.setFrameBuffer(pixels);
    file.writePixels(1);
  }
  EXPECT_NE(refusal_of(file_).find("it is deep"), std::string::npos) << refusal_of(file_);
}

TEST_F(ExrFile, ThatAsksForMoreThanItHoldsIsRefusedBeforeMemoryIsTaken) {
  write_exr(example(), file_);
  const std::string whole = read_file(file_);
  const auto number = [](std::uint32_t n) { return std::string(reinterpret_cast<const char*>(&n), 4); };
  const auto with_attribute = [&](const std::string& type, std::uint32_t size, const std::string& value) {
    write_bytes(whole.substr(0, 8) + "more" + '\0' + type + '\0' + number(size) + value + whole.substr(8));
    return refusal_of(file_);
  };
  for (const char* type : {"string", "unknown", "floatvector", "stringvector", "bytes", "preview", "chlist"})
    EXPECT_NE(with_attribute(type, 0x7FFFFFF0u, "").find("\"more\" should have 2147483632 bytes"),
              std::string::npos);
  const auto expect_no_value = [&](const std::string& type, const std::string& value) {
    const std::string refusal = with_attribute(type, static_cast<std::uint32_t>(value.size()), value);
    EXPECT_NE(refusal.find("\"more\" of type " + type), std::string::npos) << refusal;
  };
  expect_no_value("preview", number(20000) + number(20000) + number(0));
  expect_no_value("floatvector", "12345");
  expect_no_value("int", "12345");
  expect_no_value("chlist", std::string(1, '\0') + "x");
  EXPECT_NE(with_attribute("stringvector", 4, number(0x7FFFFFF0u)).find("ends too early"), std::string::npos);
  EXPECT_NE(with_attribute("chlist", 4, "RGBA").find("ends too early"), std::string::npos);
  // What is right is let through, to where the offsets of the lines are wrong.
  for (const auto& [type, value] :
       {std::pair<std::string, std::string>{"preview", number(1) + number(1) + number(0)},
        {"stringvector", number(1) + "a" + number(0)},
        {"unknown", "1"},
        {"idmanifest", number(0x7FFFFFF0u) + "packed"},
        {"int", "1234"}})
    EXPECT_EQ(with_attribute(type, static_cast<std::uint32_t>(value.size()), value).find("\"more\""),
              std::string::npos);
  const auto with_window = [&](std::uint32_t right, std::uint32_t bottom) {
    std::string bytes = whole;
    const std::size_t window = bytes.find("dataWindow") + 10 + 1 + 5 + 1 + 4;
    bytes.replace(window + 8, 8, number(right) + number(bottom));
    write_bytes(bytes);
    return refusal_of(file_);
  };
  EXPECT_NE(with_window(65535, 65535).find("65536 x 65536 pixels of 4 channels"), std::string::npos);
  EXPECT_NE(with_window(1u << 29, 0).find("536870913 x 1 pixels"), std::string::npos);
  fs::resize_file(file_, std::uintmax_t{100} << 30);
  EXPECT_NE(refusal_of(file_).find("at most 4294967296 are read"), std::string::npos);
}

TEST_F(ExrFile, CutOffAnywhereIsRefused) {
  write_exr(example(), file_);
  const std::string whole = read_file(file_);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_bytes(whole.substr(0, size));
    EXPECT_THROW(read_exr(file_), ImageFileError) << size << " of " << whole.size() << " bytes";
  }
}

TEST_F(ExrFile, WithAnyByteWrongIsReadOrRefused) {
  write_exr(example(), file_);
  const std::string whole = read_file(file_);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (char wrong : {'\0', '\x7f', '\xff'}) {
      std::string bytes = whole;
      bytes[at] = wrong;
      write_bytes(bytes);
      try {
        const LayeredImage read = read_exr(file_);
        for (const Channel& channel : read.channels)
          EXPECT_EQ(channel.values.size(), read.width * read.height);
      } catch (const ImageFileError&) {
      }
    }
  }
}

TEST_F(ExrFile, RefusalsAreOneSentenceThatNamesTheFile) {
  write_bytes("this is no picture, but it is long enough to hold a header of one");
  for (const fs::path& path : {file_, folder / "missing.exr", folder}) {
    try {
      read_exr(path);
      ADD_FAILURE() << path;
    } catch (const ImageFileError& e) {
      const std::string text = e.what();
      EXPECT_NE(text.find("\"" + path.string() + "\""), std::string::npos) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      EXPECT_EQ(text.back(), '.') << text;
    }
  }
}

TEST_F(ExrFile, IsWholeOrNotThere) {
  EXPECT_THROW(write_exr(example(), folder / "none" / "image.exr"), OutputFileError);
  EXPECT_TRUE(fs::is_empty(folder));
  if (!make_device("full", Device::kFull)) GTEST_SKIP() << "only root may make device nodes";
  EXPECT_THROW(write_exr(example(), folder / "full"), OutputFileError);
  EXPECT_TRUE(fs::is_character_file(folder / "full"));
}

TEST_F(ExrFile, OfWhatIsNoImageIsNotWritten) {
  LayeredImage flat = example();
  flat.height = 0;
  LayeredImage short_channel = example();
  short_channel.channels[1].values.pop_back();
  LayeredImage twice = example();
  twice.id_channels[0].name = "R";
  LayeredImage nameless = example();
  nameless.channels[0].name.clear();
  LayeredImage reserved = example();
  reserved.metadata.emplace_back("channels", "three");
  for (const LayeredImage& image : {LayeredImage{}, flat, short_channel, twice, nameless, reserved}) {
    EXPECT_THROW(write_exr(image, file_), std::invalid_argument);
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

}  // namespace
}  // namespace stbvh::harness
