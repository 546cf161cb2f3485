#include "harness/files/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

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

}  // namespace

std::string read_whole_file(const std::filesystem::path& path, std::size_t most_bytes) {
  const OpenFile file(path, O_RDONLY | O_NONBLOCK);  // does not wait for who writes to a pipe
  if (!file.is_open()) fail(errno);
  std::string bytes(checked_size(file, most_bytes), '\0');
  const std::size_t read = file.read_all(bytes);
  if (read == bytes.size()) return bytes;
  if (errno != 0) fail(errno);
  throw InputFileError(fmt::format("ends after {} of its {} bytes", read, bytes.size()));
}

}  // namespace stbvh::harness
