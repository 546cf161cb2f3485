/// Pictures as PNG files.
#pragma once

#include <filesystem>

#include "harness/images/image.h"

namespace stbvh::harness {

/// Writes `image` to `path`, whole or not at all (write_file). Throws OutputFileError, and
/// std::invalid_argument for an image without pixels.
void write_png(const Image& image, const std::filesystem::path& path);

}  // namespace stbvh::harness
