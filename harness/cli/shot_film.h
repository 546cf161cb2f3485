/// Frames as a film.
#pragma once

#include <filesystem>
#include <vector>

namespace stbvh::harness {

/// Writes `file` (.mp4) of PNG files, `rate` of them a second, with ffmpeg; false where there is none. Throws
/// OutputFileError, and std::runtime_error where ffmpeg fails.
bool write_film(const std::vector<std::filesystem::path>& pictures, double rate,
                const std::filesystem::path& file);

}  // namespace stbvh::harness
