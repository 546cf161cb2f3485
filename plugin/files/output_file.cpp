#include "plugin/files/output_file.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "plugin/files/open_file.h"

namespace stbvh {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw OutputFileError("Cannot write to \"" + path.string() +
                        "\": " + std::generic_category().message(error) + ".");
}

/// What a file is written to.
struct Target {
  fs::path path;                     ///< behind the links, so that they stay
  bool is_stream = false;            ///< bytes go into what is there: a pipe, a device, an open file
  std::optional<int> descriptor;     ///< of a stream that is open in this process
  std::optional<struct stat> there;  ///< where something is
};

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

/// Links of /proc mean what is open, whatever name they show.
bool is_in_proc(const fs::path& path) {
  struct statfs system;
  return statfs(folder_of(path).c_str(), &system) == 0 && system.f_type == PROC_SUPER_MAGIC;
}

/// That of this process which a link of /proc means.
std::optional<int> own_descriptor(const fs::path& link) {
  std::error_code error;
  if (fs::canonical(folder_of(link), error) != fs::canonical("/proc/self/fd", error) || error) return {};
  const std::string name = link.filename();
  int descriptor = -1;
  std::from_chars(name.data(), name.data() + name.size(), descriptor);
  return descriptor;
}

Target target_of(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as Linux
  if (path.filename().empty()) fail(path, EISDIR);
  Target target{.path = path, .is_stream = false, .descriptor = {}, .there = {}};
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(target.path, error)); ++links) {
    if (links == kMostLinks) fail(path, ELOOP);
    if (is_in_proc(target.path)) {
      target.is_stream = true;
      target.descriptor = own_descriptor(target.path);
      break;
    }
    const fs::path next = fs::read_symlink(target.path, error);
    if (error) fail(path, error.value());
    target.path = target.path.parent_path() / next;
  }
  struct stat status;
  if (stat(target.path.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) fail(path, EISDIR);
    target.is_stream = target.is_stream || !S_ISREG(status.st_mode);
    target.there = status;
  } else if (errno != ENOENT) {
    fail(path, errno);
  }
  return target;
}

std::atomic<unsigned> counter{0};  // of temporary names

/// Makes a name in `folder` that nobody has: make(name). Empty where that fails, with errno.
template <typename Make>
fs::path make_temporary(const fs::path& folder, const Make& make) {
  for (;;) {
    // Short: a file may have the longest name that there is.
    fs::path name = folder / ("stbvh-" + std::to_string(getpid()) + '-' +
                              std::to_string(counter.fetch_add(1)) + ".partial");
    if (make(name)) return name;
    if (errno != EEXIST) return {};
  }
}

/// A new file with a name, for file systems that have no others.
OpenFile new_named_file(const fs::path& folder, fs::path& name) {
  OpenFile file(-1);
  name = make_temporary(folder, [&](const fs::path& free) {
    file = OpenFile(free, O_WRONLY | O_CREAT | O_EXCL);
    return file.is_open();
  });
  return file;
}

/// A new file, without a name where that can be: nothing is left of it if the program is ended.
OpenFile new_file(const fs::path& folder, fs::path& name) {
  OpenFile file(folder, O_WRONLY | O_TMPFILE);
  return file.is_open() ? std::move(file) : new_named_file(folder, name);
}

/// As what it replaces.
bool keep_owner_and_mode(const OpenFile& file, const struct stat& before) {
  return fchown(file.descriptor(), before.st_uid, before.st_gid) == 0 &&
         fchmod(file.descriptor(), before.st_mode & 07777u) == 0;
}

/// Into a file that cannot be replaced. Where there is no room it stays as it was.
void write_in_place(const FileContent& file, const fs::path& target) {
  const OpenFile there(target, O_WRONLY);
  if (!there.is_open()) fail(file.path, errno);
  off_t size = 0;
  for (const std::string_view part : file.parts) size += static_cast<off_t>(part.size());
  const bool is_full = size > 0 && fallocate(there.descriptor(), FALLOC_FL_KEEP_SIZE, 0, size) != 0 &&
                       (errno == ENOSPC || errno == EDQUOT || errno == EFBIG);
  if (is_full || !there.write_all(file.parts) || ftruncate(there.descriptor(), size) != 0)
    fail(file.path, errno);
}

/// A file that is written whole before it is there under its name; gone with its owner unless it appeared.
class PendingFile {
 public:
  /// `file` outlives it.
  PendingFile(const FileContent& file, Target target)
      : file_(&file),
        target_(std::move(target)),
        folder_(folder_of(target_.path)),
        stream_(new_file(folder_, temporary_)) {
    if (!stream_.is_open() && !target_.there) fail(file.path, errno);
    can_replace_ = stream_.is_open() && (!target_.there || keep_owner_and_mode(stream_, *target_.there));
    if (!can_replace_ || stream_.write_all(file.parts)) return;
    const int error = errno;
    remove();
    fail(file.path, error);
  }
  PendingFile(PendingFile&& other) noexcept = default;
  ~PendingFile() { remove(); }

  void appear() {
    if (can_replace_ && has_name() && rename(temporary_.c_str(), target_.path.c_str()) == 0) {
      temporary_.clear();
    } else if (target_.there) {
      write_in_place(*file_, target_.path);
    } else {
      fail(file_->path, errno);
    }
  }

 private:
  bool has_name() {
    if (!temporary_.empty()) return true;
    const std::string unnamed = "/proc/self/fd/" + std::to_string(stream_.descriptor());
    temporary_ = make_temporary(folder_, [&](const fs::path& name) {
      return linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    });
    if (!temporary_.empty()) return true;
    // Without a /proc no file gets a name later.
    stream_ = new_named_file(folder_, temporary_);
    return stream_.is_open() && (!target_.there || keep_owner_and_mode(stream_, *target_.there)) &&
           stream_.write_all(file_->parts);
  }

  void remove() {
    if (!temporary_.empty()) unlink(temporary_.c_str());
  }

  const FileContent* file_;
  Target target_;
  fs::path folder_, temporary_;  // a moved-from path is empty
  OpenFile stream_;
  bool can_replace_ = false;
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

void write_stream(const FileContent& file, const Target& target) {
  const BrokenPipesAreErrors guard;
  std::fflush(stdout);  // what was printed before stands before it
  const OpenFile stream = target.descriptor ? OpenFile(fcntl(*target.descriptor, F_DUPFD_CLOEXEC, 0))
                                            : OpenFile(target.path, O_WRONLY | O_APPEND);
  if (!stream.is_open() || !stream.write_all(file.parts)) fail(file.path, errno);
}

/// What is there must be writable itself, also where it could be replaced.
void check_there(const fs::path& path, const Target& target) {
  if (target.descriptor) {
    const int flags = fcntl(*target.descriptor, F_GETFL);
    if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY) fail(path, EBADF);
  } else if (faccessat(AT_FDCWD, target.path.c_str(), W_OK, AT_EACCESS) != 0) {
    fail(path, errno);  // not opened: who reads a pipe would take the closing for its end
  }
}

}  // namespace

bool is_stream(const fs::path& path) {
  return target_of(path).is_stream;
}

void check_writable(const fs::path& path) {
  const Target target = target_of(path);
  if (target.there) return check_there(path, target);
  fs::path temporary;
  if (!new_file(folder_of(target.path), temporary).is_open()) fail(path, errno);
  if (!temporary.empty()) unlink(temporary.c_str());
}

void write_file(const fs::path& path, std::string_view bytes) {
  const FileContent file{path, {bytes}};
  write_files({&file, 1});
}

void write_files(std::span<const FileContent> files) {
  std::vector<PendingFile> pending;
  pending.reserve(files.size());
  for (const FileContent& file : files) {
    Target target = target_of(file.path);
    if (target.there) check_there(file.path, target);
    if (target.is_stream) {
      write_stream(file, target);
    } else {
      pending.emplace_back(file, std::move(target));
    }
  }
  for (PendingFile& file : pending) file.appear();
}

}  // namespace stbvh
