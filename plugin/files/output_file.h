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

/// Whether write_file writes into what `path` is: a pipe, a device, or what is open (/dev/stdout, /dev/fd/3),
/// also where that is a file.
bool is_stream(const std::filesystem::path& path);

/// Writes `bytes` to `path`: into a new file beside it, which has no name before it is complete where the
/// file system knows such, then renamed, so that the file appears whole or not at all. A link stays a link; a
/// file that is replaced keeps owner and mode. Where that cannot be (no right to the folder, a mount point)
/// the bytes go into the file that is there, which must be writable in any case. A stream gets them behind
/// what it has; a pipe waits for who reads it. Throws OutputFileError.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// A file to be written; its parts stand one behind the other.
struct FileContent {
  std::filesystem::path path;
  std::vector<std::string_view> parts;
};

/// The same for files that need each other: none is renamed before all are written.
void write_files(std::span<const FileContent> files);

}  // namespace stbvh
