/// Files that are read whole.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace stbvh::harness {

/// A file that could not be read; what() says why, to stand behind the file's name or "it": "does not exist".
struct InputFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Most bytes of text that a person writes: options, commands.
inline constexpr std::size_t kMaxHandwrittenBytes = std::size_t{16} << 20;

/// All bytes of a regular file. Throws InputFileError, also for a file of more than `most_bytes`, before any
/// memory is taken for it: a sparse file of a terabyte takes no room on the disk.
std::string read_whole_file(const std::filesystem::path& path, std::size_t most_bytes);

/// The same for text in UTF-8, without the byte order mark that it may begin with. Refuses text whose mark
/// says UTF-16 or UTF-32.
std::string read_text_file(const std::filesystem::path& path, std::size_t most_bytes);

/// Bytes of a file of which parts are read: refused as by read_whole_file().
std::size_t input_file_size(const std::filesystem::path& path, std::size_t most_bytes);

}  // namespace stbvh::harness
