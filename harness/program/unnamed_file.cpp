#include "harness/program/unnamed_file.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace stbvh::harness {

UnnamedFile::UnnamedFile() {
  std::string name = (std::filesystem::temp_directory_path() / "stbvh-XXXXXX").string();
  descriptor_ = mkstemp(name.data());
  if (descriptor_ < 0)
    throw std::system_error(errno, std::generic_category(), fmt::format("\"{}\" cannot be written", name));
  unlink(name.c_str());
}

void UnnamedFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      throw std::system_error(
          errno, std::generic_category(),
          fmt::format("A file in {} cannot be written", std::filesystem::temp_directory_path().string()));
    }
  }
}

UnnamedFile::~UnnamedFile() {
  close(descriptor_);
}

std::filesystem::path UnnamedFile::path() const {
  return fmt::format("/proc/self/fd/{}", descriptor_);
}

}  // namespace stbvh::harness
