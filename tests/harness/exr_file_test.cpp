/// OpenEXR files: what is written is read again; broken ones are refused.
#include "harness/images/exr_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
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
  EXPECT_THROW(write_exr(example(), "/dev/full"), OutputFileError);
  EXPECT_THROW(write_exr(example(), folder / "none" / "image.exr"), OutputFileError);
  EXPECT_TRUE(fs::is_empty(folder));
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
