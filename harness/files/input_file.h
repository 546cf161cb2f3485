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

/// All bytes of a regular file. Throws InputFileError, also for a file of more than `most_bytes`, before any
/// memory is taken for it: a sparse file of a terabyte takes no room on the disk.
std::string read_whole_file(const std::filesystem::path& path, std::size_t most_bytes);

}  // namespace stbvh::harness
