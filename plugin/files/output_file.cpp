#include "plugin/files/output_file.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include "plugin/files/open_file.h"

namespace stbvh {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw OutputFileError("Cannot write to \"" + path.string() +
                        "\": " + std::generic_category().message(error) + ".");
}

bool is_special(const fs::path& path) {
  std::error_code ignored;
  const auto status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// The file behind `path`, so that a link stays a link, also one to a file that is not there yet.
fs::path target_of(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as Linux
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
  name += '.' + std::to_string(getpid()) + '-' + std::to_string(counter.fetch_add(1)) + ".partial";
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

/// While it lives, a pipe that nobody reads any more is an error of this thread (EPIPE), and does not end the
/// process.
class BrokenPipesAreErrors {
 public:
  BrokenPipesAreErrors() {
    sigset_t pending;
    sigemptyset(&broken_pipe_);
    sigaddset(&broken_pipe_, SIGPIPE);
    sigpending(&pending);
    was_pending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &broken_pipe_, &before_);
  }
  ~BrokenPipesAreErrors() {
    constexpr timespec kNow{};
    if (!was_pending_) sigtimedwait(&broken_pipe_, nullptr, &kNow);  // takes away what has been raised here
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  BrokenPipesAreErrors(const BrokenPipesAreErrors&) = delete;
  BrokenPipesAreErrors& operator=(const BrokenPipesAreErrors&) = delete;

 private:
  sigset_t broken_pipe_, before_;
  bool was_pending_;
};

void write_special(const FileContent& file) {
  const BrokenPipesAreErrors guard;
  const OpenFile special(file.path, O_WRONLY);
  if (!special.is_open() || !special.write_all(file.parts)) fail(file.path, errno);
}

}  // namespace

void check_writable(const fs::path& path) {
  if (path.filename().empty()) fail(path, EISDIR);
  if (is_special(path)) {
    if (fs::is_directory(path)) fail(path, EISDIR);
    // Not opened: who reads a pipe would take the closing for its end.
    if (access(path.c_str(), W_OK) != 0) fail(path, errno);
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
    if (is_special(file.path)) {
      write_special(file);
    } else {
      pending.emplace_back(file);
    }
  }
  for (PendingFile& file : pending) file.appear();
}

}  // namespace stbvh
