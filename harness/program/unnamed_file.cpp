#include "harness/program/unnamed_file.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "harness/files/user_error.h"

namespace stbvh::harness {

std::string temporary_folder() {
  const char* const folder = std::getenv("TMPDIR");
  return folder != nullptr && *folder != '\0' ? folder : "/tmp";
}

UnnamedFile::UnnamedFile() {
  std::string name = temporary_folder() + "/stbvh-XXXXXX";
  descriptor_ = mkstemp(name.data());
  if (descriptor_ < 0)
    throw UserError(fmt::format("No file can be made in \"{}\" (TMPDIR): {}.", temporary_folder(),
                                std::generic_category().message(errno)));
  unlink(name.c_str());
}

void UnnamedFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      throw std::system_error(errno, std::generic_category(),
                              fmt::format("A file in \"{}\" (TMPDIR) cannot be written", temporary_folder()));
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
