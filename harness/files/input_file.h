/// Files that are read. Not with the standard library's streams: where memory runs out they end early, as at
/// the end of a file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

#include "plugin/files/open_file.h"

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

/// The same for text in any encoding. Refuses a file in whose beginning there is a row of zeros, before the
/// rest is read: a sparse file has nothing else.
std::string read_whole_text(const std::filesystem::path& path, std::size_t most_bytes);

/// The same for text in UTF-8, without the byte order mark that it may begin with. Refuses text whose mark
/// says UTF-16 or UTF-32, or that has bytes of 0, as such text has without a mark.
std::string read_text_file(const std::filesystem::path& path, std::size_t most_bytes);

/// A file of which parts are read: refused as by read_whole_file().
class InputFile {
 public:
  InputFile(const std::filesystem::path& path, std::size_t most_bytes);

  std::size_t size() const { return size_; }
  /// Fills `bytes` with what stands from `offset` on. Throws InputFileError.
  void read(std::size_t offset, std::span<char> bytes) const;

 private:
  OpenFile file_;
  std::size_t size_;
};

/// What a file in /proc begins with, 4096 bytes at most; nothing where it cannot be read.
std::string read_proc_file(const std::filesystem::path& path);

}  // namespace stbvh::harness
