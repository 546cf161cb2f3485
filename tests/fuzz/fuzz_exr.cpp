/// Bytes -> an OpenEXR file -> a picture, or the refusal; a picture does not differ from itself.
#include "harness/images/compare.h"
#include "harness/images/exr_file.h"
#include "reader_input.h"
#include "require.h"

namespace stbvh::fuzz {
namespace {

constexpr std::size_t kMostCompared = 256;  // pixels: FLIP takes time

void check_picture(const harness::LayeredImage& picture) {
  const std::size_t pixels = picture.width * picture.height;
  require(pixels > 0, "a picture has pixels");
  for (const auto& channel : picture.channels)
    require(channel.values.size() == pixels, "a channel has every pixel");
  for (const auto& channel : picture.id_channels)
    require(channel.values.size() == pixels, "a channel of ids has every pixel");
  if (pixels > kMostCompared) return;
  try {
    const harness::Comparison found = harness::compare(picture, picture);
    require(found.differing == 0 && found.warnings.empty(), "a picture is the same as itself");
  } catch (const harness::ComparisonError&) {
  }
}

}  // namespace

void run(Bytes bytes) {
  static const InputFolder folder;
  try {
    check_picture(harness::read_exr(folder.write("input.exr", bytes)));
  } catch (const harness::ImageFileError&) {
  }
}

}  // namespace stbvh::fuzz
