/// Layered images as OpenEXR files.
#pragma once

#include <filesystem>

#include "harness/files/user_error.h"
#include "harness/images/layered_image.h"

namespace stbvh::harness {

/// A picture that is missing or broken; what() is one sentence for the user.
struct ImageFileError : UserError {
  using UserError::UserError;
};

/// Writes `image` to `path`, whole or not at all (write_file): float channels as 32-bit floats, id channels
/// as 32-bit unsigned integers, metadata as string attributes. Throws OutputFileError, and
/// std::invalid_argument for an image without pixels or with a channel of another size.
void write_exr(const LayeredImage& image, const std::filesystem::path& path);

/// Reads a scan-line or tiled file of one part, of tiles the finest level: half and float channels as floats,
/// unsigned ones as ids, string attributes as metadata. Throws ImageFileError, also for files of several
/// parts, with deep pixels or with channels that do not have every pixel, and before memory is taken for more
/// than the file can hold.
LayeredImage read_exr(const std::filesystem::path& path);

}  // namespace stbvh::harness
