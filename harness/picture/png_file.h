/// Pictures as PNG files.
#pragma once

#include <filesystem>
#include <stdexcept>

#include "harness/picture/image.h"

namespace stbvh::harness {

/// A picture that could not be written; what() is one sentence for the user.
struct PictureFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Writes `image` to `path`. The file appears whole or not at all: it is written under a temporary name
/// beside `path` and renamed. What is not a regular file (a device, a pipe) is written to directly. Throws
/// PictureFileError, for an image without pixels too.
void write_png(const Image& image, const std::filesystem::path& path);

}  // namespace stbvh::harness
