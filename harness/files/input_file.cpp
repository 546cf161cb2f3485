#include "harness/files/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include "plugin/files/open_file.h"

namespace stbvh::harness {
namespace {

[[noreturn]] void fail(int error) {
  if (error == ENOENT) throw InputFileError("does not exist");
  throw InputFileError(fmt::format("cannot be read: {}", std::generic_category().message(error)));
}

/// The size of a regular file.
std::size_t checked_size(const OpenFile& file, std::size_t most_bytes) {
  struct stat status {};
  if (fstat(file.descriptor(), &status) != 0) fail(errno);
  if (!S_ISREG(status.st_mode)) throw InputFileError("is not a regular file");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > most_bytes) {
    throw InputFileError(fmt::format("has {} bytes, but at most {} are read", size, most_bytes));
  }
  return size;
}

constexpr int kReading = O_RDONLY | O_NONBLOCK;  // does not wait for who writes to a pipe

/// Byte order marks of what is not read; longer ones before those that they begin with.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kWideMarks{{
    {{"\xFF\xFE\0\0", 4}, "UTF-32"},
    {{"\0\0\xFE\xFF", 4}, "UTF-32"},
    {"\xFF\xFE", "UTF-16"},
    {"\xFE\xFF", "UTF-16"},
}};
constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";

}  // namespace

InputFile::InputFile(const std::filesystem::path& path, std::size_t most_bytes) : file_(path, kReading) {
  if (!file_.is_open()) fail(errno);
  size_ = checked_size(file_, most_bytes);
}

void InputFile::read(std::size_t offset, std::span<char> bytes) const {
  const std::size_t read = file_.read_all(bytes, offset);
  if (read == bytes.size()) return;
  if (errno != 0) fail(errno);
  throw InputFileError(fmt::format("ends after {} of its {} bytes", offset + read, size_));
}

std::string read_text_file(const std::filesystem::path& path, std::size_t most_bytes) {
  std::string text = read_whole_text(path, most_bytes);
  for (const auto& [mark, encoding] : kWideMarks) {
    if (text.starts_with(mark)) throw InputFileError(fmt::format("is {} text, not UTF-8", encoding));
  }
  if (text.find('\0') != std::string::npos)
    throw InputFileError("has bytes of 0, as UTF-16 and binary files do: it is not UTF-8 text");
  if (text.starts_with(kUtf8Mark)) text.erase(0, kUtf8Mark.size());
  return text;
}

std::string read_whole_file(const std::filesystem::path& path, std::size_t most_bytes) {
  const InputFile file(path, most_bytes);
  std::string bytes(file.size(), '\0');
  file.read(0, bytes);
  return bytes;
}

std::string read_whole_text(const std::filesystem::path& path, std::size_t most_bytes) {
  constexpr std::size_t kBeginning = 4096, kRow = 8;  // more zeros than wide characters have
  const InputFile file(path, most_bytes);
  std::string bytes(std::min(kBeginning, file.size()), '\0');
  file.read(0, bytes);
  if (bytes.find(std::string(kRow, '\0')) != std::string::npos) throw InputFileError("is not text");
  const std::size_t begun = bytes.size();
  bytes.resize(file.size());
  file.read(begun, std::span(bytes).subspan(begun));
  return bytes;
}

std::string read_proc_file(const std::filesystem::path& path) {
  const OpenFile file(path, kReading);
  std::string bytes(4096, '\0');
  bytes.resize(file.read_all(bytes, 0));
  return bytes;
}

}  // namespace stbvh::harness
