#include "harness/picture/png_file.h"

#include <fmt/format.h>
#include <png.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw PictureFileError(fmt::format("Cannot write the picture {}: {}.", path.string(), reason));
}

/// The PNG file in memory. The simplified API of libpng needs no longjmp.
std::vector<std::uint8_t> encode(const Image& image, const fs::path& path) {
  if (image.width == 0 || image.height == 0 || image.rgb.size() != image.width * image.height * 3 ||
      image.width > 0x7FFFFFFFu || image.height > 0x7FFFFFFFu) {
    fail(path, fmt::format("{} x {} pixels in {} bytes is not an image", image.width, image.height,
                           image.rgb.size()));
  }
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<std::uint8_t> file(bytes);
  if (png_image_write_to_memory(&header, file.data(), &bytes, 0, image.rgb.data(), 0, nullptr) == 0) {
    fail(path, header.message);
  }
  file.resize(bytes);
  return file;
}

/// Writes all bytes through to the system; 0, or the errno of the first call that failed.
int write_bytes(const std::vector<std::uint8_t>& bytes, const fs::path& path, const char* mode) {
  errno = 0;
  std::FILE* file = std::fopen(path.c_str(), mode);
  if (file == nullptr) return errno;
  int error = 0;
  const auto check = [&error](bool ok) {
    if (!ok && error == 0) error = errno != 0 ? errno : EIO;
  };
  check(std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size());
  check(std::fflush(file) == 0);
  check(std::ferror(file) == 0);
  check(std::fclose(file) == 0);
  return error;
}

/// A name beside `target` that no other writer uses.
fs::path temporary_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  fs::path name = target;
  name += fmt::format(".{}-{}.partial", ::getpid(), counter.fetch_add(1));
  return name;
}

void write_and_rename(const std::vector<std::uint8_t>& bytes, const fs::path& target, const fs::path& path) {
  const fs::path temporary = temporary_name(target);
  std::error_code ignored;
  if (const int error = write_bytes(bytes, temporary, "wbx"); error != 0) {
    if (error != EEXIST) fs::remove(temporary, ignored);
    fail(path, std::strerror(error));
  }
  std::error_code error;
  fs::rename(temporary, target, error);
  if (error) {
    fs::remove(temporary, ignored);
    fail(path, error.message());
  }
}

}  // namespace

void write_png(const Image& image, const fs::path& path) {
  const std::vector<std::uint8_t> bytes = encode(image, path);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) fail(path, "it is a directory");
  if (!fs::exists(status)) return write_and_rename(bytes, path, path);
  if (fs::is_regular_file(status)) {
    const fs::path target = fs::canonical(path, error);  // a link stays a link
    if (error) fail(path, error.message());
    return write_and_rename(bytes, target, path);
  }
  if (const int written = write_bytes(bytes, path, "wb"); written != 0) fail(path, std::strerror(written));
}

}  // namespace stbvh::harness
