#include "harness/files/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "harness/files/open_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw OutputFileError(
      fmt::format("Cannot write to \"{}\": {}.", path.string(), std::generic_category().message(error)));
}

bool is_special(const fs::path& path) {
  std::error_code ignored;
  const auto status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// The file behind `path`, there or not, so that a link stays a link.
fs::path target_of(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as the kernel
  fs::path target = path;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(target, error)); ++links) {
    if (links == kMostLinks) fail(path, ELOOP);
    const fs::path next = fs::read_symlink(target, error);
    if (error) fail(path, error.value());
    target = target.parent_path() / next;
  }
  return target;
}

/// A name beside `target` that no other writer uses.
fs::path temporary_beside(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  fs::path name = target;
  name += fmt::format(".{}-{}.partial", getpid(), counter.fetch_add(1));
  return name;
}

constexpr int kNewFile = O_WRONLY | O_CREAT | O_EXCL;

/// A file that is written whole, under its temporary name; gone with its owner unless it appeared.
class PendingFile {
 public:
  explicit PendingFile(const FileContent& file)
      : path_(file.path), target_(target_of(file.path)), temporary_(temporary_beside(target_)) {
    OpenFile stream(temporary_, kNewFile);
    if (!stream.is_open()) fail(path_, errno);
    if (stream.write_all(file.parts)) return;
    const int error = errno;
    unlink(temporary_.c_str());
    fail(path_, error);
  }
  PendingFile(PendingFile&& other) noexcept = default;
  ~PendingFile() {
    if (!temporary_.empty()) unlink(temporary_.c_str());
  }

  void appear() {
    if (rename(temporary_.c_str(), target_.c_str()) != 0) fail(path_, errno);
    temporary_.clear();
  }

 private:
  fs::path path_, target_, temporary_;  // a moved-from path is empty
};

}  // namespace

void check_writable(const fs::path& path) {
  if (path.filename().empty()) fail(path, EISDIR);
  if (is_special(path)) {
    const OpenFile file(path, O_WRONLY | O_NONBLOCK);
    if (!file.is_open() && errno != ENXIO) fail(path, errno);  // ENXIO: a pipe that nobody reads yet
    return;
  }
  const fs::path temporary = temporary_beside(target_of(path));
  const OpenFile file(temporary, kNewFile);
  if (!file.is_open()) fail(path, errno);
  unlink(temporary.c_str());
}

void write_file(const fs::path& path, std::string_view bytes) {
  const FileContent file{path, {bytes}};
  write_files({&file, 1});
}

void write_files(std::span<const FileContent> files) {
  std::vector<PendingFile> pending;
  pending.reserve(files.size());
  for (const FileContent& file : files) {
    if (!is_special(file.path)) {
      pending.emplace_back(file);
      continue;
    }
    OpenFile special(file.path, O_WRONLY);
    if (!special.is_open() || !special.write_all(file.parts)) fail(file.path, errno);
  }
  for (PendingFile& file : pending) file.appear();
}

}  // namespace stbvh::harness
