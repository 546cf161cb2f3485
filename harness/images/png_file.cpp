#include "harness/images/png_file.h"

#include <fmt/format.h>
#include <png.h>

#include <stdexcept>
#include <string>

#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

/// The PNG file in memory. The simplified API of libpng needs no longjmp.
std::string encode(const Image& image) {
  if (image.width == 0 || image.height == 0 || image.rgb.size() != image.width * image.height * 3 ||
      image.width > 0x7FFFFFFFu || image.height > 0x7FFFFFFFu) {
    throw std::invalid_argument(fmt::format("{} x {} pixels in {} bytes is not an image.", image.width,
                                            image.height, image.rgb.size()));
  }
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string file(bytes, '\0');
  if (png_image_write_to_memory(&header, file.data(), &bytes, 0, image.rgb.data(), 0, nullptr) == 0) {
    throw std::runtime_error(fmt::format("The picture cannot be made: {}.", header.message));
  }
  file.resize(bytes);
  return file;
}

}  // namespace

void write_png(const Image& image, const std::filesystem::path& path) {
  write_file(path, encode(image));
}

}  // namespace stbvh::harness
