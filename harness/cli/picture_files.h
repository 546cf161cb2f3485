/// Where pictures are written.
#pragma once

#include <filesystem>

namespace stbvh::harness {

/// The PNG to look at that belongs to an OpenEXR file.
std::filesystem::path png_beside(std::filesystem::path file);

/// Refuses OpenEXR files that cannot be written, or whose names are those of PNG files; likewise the PNG
/// beside one where that is written too. Throws UsageError and OutputFileError.
void check_picture_file(const std::filesystem::path& file, bool with_png);

}  // namespace stbvh::harness
