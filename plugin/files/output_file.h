/// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace stbvh {

/// A file that could not be written; what() is one sentence for the user.
struct OutputFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws OutputFileError if write_file could not write to `path` as things stand. Leaves nothing behind.
void check_writable(const std::filesystem::path& path);

/// Writes `bytes` to `path`: under a temporary name beside it, then renamed, so that the file appears whole
/// or not at all. A link stays a link. What is not a regular file (a device, a pipe) is written to directly;
/// a pipe waits for who reads it. Throws OutputFileError.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// A file to be written; its parts stand one behind the other.
struct FileContent {
  std::filesystem::path path;
  std::vector<std::string_view> parts;
};

/// The same for files that need each other: none is renamed before all are written.
void write_files(std::span<const FileContent> files);

}  // namespace stbvh
