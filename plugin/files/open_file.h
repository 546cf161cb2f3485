/// A file descriptor with an owner.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>

namespace stbvh {

class OpenFile {
 public:
  /// `flags` as those of open(). A failure is in errno.
  OpenFile(const std::filesystem::path& path, int flags)
      : descriptor_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OpenFile(OpenFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }

  /// How many bytes arrived from `offset` on: fewer than asked for at the end of the file, with errno 0, or
  /// after a failure.
  std::size_t read_all(std::span<char> bytes, std::size_t offset) const {
    errno = 0;
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n =
          pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      done += static_cast<std::size_t>(n);
    }
    return done;
  }

  /// Whether all parts arrived, also on the disk where there is one. A failure is in errno.
  bool write_all(std::span<const std::string_view> parts) const {
    for (const std::string_view part : parts) {
      if (!write_part(part)) return false;
    }
    return fsync(descriptor_) == 0 || errno == EINVAL || errno == EROFS;
  }

 private:
  bool write_part(std::string_view bytes) const {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n = write(descriptor_, bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return true;
  }

  int descriptor_;
};

}  // namespace stbvh
