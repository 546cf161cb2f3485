#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "harness/files/input_file.h"
#include "harness/files/numbers.h"
#include "harness/files/text.h"
#include "plugin/files/open_file.h"
#include "plugin/files/output_file.h"
#include "tests/harness/temporary_folder.h"

namespace {

bool has_nameless_files = true, can_name_files = true;  // the file system; the system, with a /proc

}  // namespace

/// Both stand before the system's.
extern "C" int open(const char* path, int flags, ...) {
  if (!has_nameless_files && (flags & O_TMPFILE) == O_TMPFILE) {
    errno = EOPNOTSUPP;
    return -1;
  }
  return openat(AT_FDCWD, path, flags, 0666);
}
extern "C" int linkat(int, const char* from, int, const char* to, int) noexcept {
  using Link = int (*)(int, const char*, int, const char*, int);
  static const auto link = reinterpret_cast<Link>(dlsym(RTLD_NEXT, "linkat"));
  if (can_name_files) return link(AT_FDCWD, from, AT_FDCWD, to, AT_SYMLINK_FOLLOW);
  errno = ENOENT;
  return -1;
}

namespace stbvh::harness {
namespace {

constexpr std::size_t kMost = 100;

std::string refusal_of(const fs::path& path) {
  try {
    read_whole_file(path, kMost);
  } catch (const InputFileError& e) {
    return e.what();
  }
  return "";
}

class InputFiles : public TemporaryFolderTest {};

TEST_F(InputFiles, IsReadWhole) {
  const std::string bytes("a\0b\xFF\r\n", 6);
  EXPECT_EQ(read_whole_file(write("a.bin", bytes), kMost), bytes);
  EXPECT_EQ(read_whole_file(write("empty", ""), 0), "");
  fs::create_symlink(folder / "a.bin", folder / "link");
  EXPECT_EQ(read_whole_file(folder / "link", kMost), bytes);
}

TEST_F(InputFiles, ThatIsTooLargeIsRefusedByItsSize) {
  const std::string bytes(kMost, 'x');
  EXPECT_EQ(read_whole_file(write("fits", bytes), kMost), bytes);
  EXPECT_EQ(refusal_of(write("larger", bytes + "x")), "has 101 bytes, but at most 100 are read");
  fs::resize_file(write("sparse", ""), std::uintmax_t{100} << 30);
  EXPECT_EQ(refusal_of(folder / "sparse"), "has 107374182400 bytes, but at most 100 are read");
}

TEST_F(InputFiles, WhatIsNotAFileIsRefused) {
  EXPECT_EQ(refusal_of(folder / "none"), "does not exist");
  EXPECT_EQ(refusal_of(folder), "is not a regular file");
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  EXPECT_EQ(refusal_of(folder / "pipe"), "is not a regular file");
  fs::create_symlink(folder / "b", folder / "a");
  fs::create_symlink(folder / "a", folder / "b");
  EXPECT_EQ(refusal_of(folder / "a"), "cannot be read: Too many levels of symbolic links");
}

TEST_F(InputFiles, TextLosesItsByteOrderMark) {
  EXPECT_EQ(read_text_file(write("a", "\xEF\xBB\xBFtext\xEF\xBB\xBF"), kMost), "text\xEF\xBB\xBF");
  EXPECT_EQ(read_text_file(write("a", "\xEF\xBB"), kMost), "\xEF\xBB");
  EXPECT_EQ(read_text_file(write("a", ""), kMost), "");
  using namespace std::string_view_literals;
  for (const auto& [mark, encoding] :
       {std::pair{"\xFF\xFE"sv, "UTF-16"}, std::pair{"\xFE\xFF"sv, "UTF-16"},
        std::pair{"\xFF\xFE\0\0"sv, "UTF-32"}, std::pair{"\0\0\xFE\xFF"sv, "UTF-32"}}) {
    try {
      read_text_file(write("a", mark), kMost);
      ADD_FAILURE() << encoding;
    } catch (const InputFileError& e) {
      EXPECT_EQ(std::string(e.what()), std::string("is ") + encoding + " text, not UTF-8");
    }
  }
}

TEST_F(InputFiles, TextHasNoBytesOfZero) {
  using namespace std::string_view_literals;
  for (const std::string_view text : {"v\0 \0"sv, "\0v\0 "sv, "text\0"sv}) {
    try {
      read_text_file(write("a", text), kMost);
      ADD_FAILURE() << text;
    } catch (const InputFileError& e) {
      EXPECT_EQ(std::string_view(e.what()),
                "has bytes of 0, as UTF-16 and binary files do: it is not UTF-8 text");
    }
  }
}

TEST(Text, LinesEndAsOnAllSystems) {
  std::string_view rest = "a\nb\r\nc\r\rd\n\re\n";
  for (const std::string_view line : {"a", "b", "c", "", "d", "", "e"}) {
    EXPECT_FALSE(rest.empty());
    EXPECT_EQ(take_line(rest), line);
  }
  EXPECT_EQ(rest, "");
  EXPECT_EQ(take_line(rest), "");
  rest = "no end";
  EXPECT_EQ(take_line(rest), "no end");
}

TEST(Text, CommentsBeginAWord) {
  EXPECT_EQ(without_comment("# all"), "");
  EXPECT_EQ(without_comment("a b # c # d"), "a b ");
  EXPECT_EQ(without_comment("a\t#c"), "a\t");
  EXPECT_EQ(without_comment("1.#INF w_##.obj #c"), "1.#INF w_##.obj ");
  EXPECT_EQ(without_comment("a#"), "a#");
  EXPECT_EQ(without_comment(""), "");
}

TEST(Numbers, AreWholeWords) {
  EXPECT_EQ(to_number<float>("+0.5"), 0.5f);
  EXPECT_EQ(to_number<float>("-1.e1"), -10.0f);
  EXPECT_EQ(to_number<float>("1e-46"), 0.0f);
  EXPECT_EQ(to_number<float>("1e-999"), 0.0f);
  EXPECT_EQ(to_number<int>("+7"), 7);
  for (const char* const word :
       {"", "+", "-", "+-1", "-+1", "++1", "1,5", "1x", "1e400x", "0x1", "1.#", "1.#x", "2.#INF"})
    EXPECT_FALSE(to_number<float>(word)) << word;
  for (const char* const word : {"1.5", "99999999999999999999", "1.#INF", "nan"})
    EXPECT_FALSE(to_number<int>(word)) << word;
}

TEST(Numbers, MayBeInfiniteOrNone) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const std::string word : {"inf", "Infinity", "1e39", "1e999", "1.#INF", "1.#INF00", "1.#INF00e+000"}) {
    EXPECT_EQ(to_number<float>(word), kInfinity) << word;
    EXPECT_EQ(to_number<float>("+" + word), kInfinity) << word;
    EXPECT_EQ(to_number<float>("-" + word), -kInfinity) << word;
  }
  for (const char* const word :
       {"nan", "-NaN", "-nan(ind)", "nan(snan)", "-1.#IND", "1.#QNAN", "1.#SNAN0", "-1.#IND00", "1.#J"}) {
    const auto value = to_number<float>(word);
    ASSERT_TRUE(value) << word;
    EXPECT_TRUE(std::isnan(*value)) << word;
  }
}

TEST_F(InputFiles, TextThatBeginsWithZerosIsRefusedBeforeTheRestIsRead) {
  constexpr std::size_t kAnything = std::size_t{1} << 50;
  for (const char* const beginning : {"", "# made by a program\n"}) {
    fs::resize_file(write("sparse", beginning), std::uintmax_t{1} << 42);  // more than any memory
    try {
      read_whole_text(folder / "sparse", kAnything);
      ADD_FAILURE() << beginning;
    } catch (const InputFileError& e) {
      EXPECT_STREQ(e.what(), "is not text");
    }
    EXPECT_THROW(read_text_file(folder / "sparse", kAnything), InputFileError);
  }
  const std::string longer = "<scene>" + std::string(10'000, ' ') + "</scene>";
  EXPECT_EQ(read_whole_text(write("a", longer), kAnything), longer);
  const std::string wide("\xFF\xFE<\0s\0", 6);
  EXPECT_EQ(read_whole_text(write("a", wide), kAnything), wide);
}

TEST_F(InputFiles, IsReadInParts) {
  const InputFile file(write("a", "abcd"), 4);
  EXPECT_EQ(file.size(), 4u);
  std::string part(2, ' ');
  file.read(1, part);
  EXPECT_EQ(part, "bc");
  EXPECT_THROW(file.read(3, part), InputFileError);
  EXPECT_THROW(InputFile(folder / "a", 3), InputFileError);
  EXPECT_THROW(InputFile(folder, 3), InputFileError);
}

TEST(ProcFile, IsReadFromItsBeginning) {
  EXPECT_TRUE(read_proc_file("/proc/meminfo").starts_with("MemTotal:"));
  EXPECT_EQ(read_proc_file("/proc/nothing"), "");
}

class OutputFile : public TemporaryFolderTest {};

TEST_F(OutputFile, AppearsWhole) {
  const auto path = folder / "a.json";
  check_writable(path);
  EXPECT_FALSE(fs::exists(path));
  write_file(path, "one");
  write_file(path, "two");
  EXPECT_EQ(read_file(path), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

TEST_F(OutputFile, LinksStayLinks) {
  write_file(folder / "a.json", "one");
  fs::create_symlink(folder / "a.json", folder / "link");
  check_writable(folder / "link");
  write_file(folder / "link", "two");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_file(folder / "a.json"), "two");
}

TEST_F(OutputFile, FilesThatNeedEachOtherAppearTogether) {
  const auto a = folder / "a.xml", b = folder / "b.bin";
  const std::vector<FileContent> both{{a, {"one ", "", "two"}}, {b, {}}};
  write_files(both);
  EXPECT_EQ(read_file(a), "one two");
  EXPECT_EQ(fs::file_size(b), 0u);
  const auto expect_neither = [&](const fs::path& bad) {
    const std::vector<FileContent> one_fails{{a, {"new"}}, {bad, {"x"}}};
    EXPECT_THROW(write_files(one_fails), OutputFileError);
    EXPECT_EQ(read_file(a), "one two");
  };
  expect_neither(folder / "none" / "b.bin");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);
  if (make_device("full", Device::kFull)) expect_neither(folder / "full");
}

TEST_F(OutputFile, UnwritablePlacesAreRefused) {
  EXPECT_THROW(check_writable(folder / "none" / "a.json"), OutputFileError);
  EXPECT_THROW(check_writable(folder), OutputFileError);
  EXPECT_THROW(check_writable(folder / ""), OutputFileError);
  EXPECT_THROW(write_file(folder / "none" / "a.json", "x"), OutputFileError);
}

TEST_F(OutputFile, HasANameAsLongAsThereIs) {
  const std::string longest(255, 'a');
  check_writable(folder / longest);
  write_file(folder / longest, "one");
  EXPECT_EQ(read_file(folder / longest), "one");
  EXPECT_THROW(check_writable(folder / (longest + "a")), OutputFileError);
  EXPECT_THROW(write_file(folder / (longest + "a"), "one"), OutputFileError);
}

struct stat status_of(const fs::path& file) {
  struct stat status;
  EXPECT_EQ(stat(file.c_str(), &status), 0) << file;
  return status;
}

TEST_F(OutputFile, KeepsOwnerAndModeOfWhatItReplaces) {
  fs::permissions(write("a", "one"), fs::perms::owner_read | fs::perms::owner_write);
  const bool is_root = geteuid() == 0;
  if (is_root) {
    ASSERT_EQ(chown(at("a").c_str(), 65534, 65533), 0);
  }
  const ino_t before = status_of(folder / "a").st_ino;
  write_file(folder / "a", "two");
  const struct stat after = status_of(folder / "a");
  EXPECT_EQ(read_file(folder / "a"), "two");
  EXPECT_NE(after.st_ino, before);
  EXPECT_EQ(after.st_mode & 07777u, 0600u);
  EXPECT_EQ(after.st_uid, is_root ? 65534 : geteuid());
  EXPECT_EQ(after.st_gid, is_root ? 65533 : getegid());
}

TEST_F(OutputFile, IsWholeWhereFilesHaveNamesFromTheBeginning) {
  const fs::path file = write("a", "one");
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  for (bool* const can : {&has_nameless_files, &can_name_files}) {
    *can = false;
    check_writable(file);
    write_file(file, "two");
    check_writable(folder / "b");
    write_file(folder / "b", "new");
    write_file(folder / "b", std::string(1 << 20, 'b'));
    EXPECT_THROW(write_file(folder / "none" / "b", "x"), OutputFileError);
    *can = true;
    EXPECT_EQ(read_file(file), "two");
    EXPECT_EQ(read_file(folder / "b"), std::string(1 << 20, 'b'));
    EXPECT_EQ(status_of(file).st_mode & 07777u, 0600u);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);
    fs::remove(folder / "b");
  }
}

TEST_F(OutputFile, OpenFilesGetTheBytesBehindWhatTheyHave) {
  const fs::path log = write("log", "my old log\n");
  const OpenFile own(log, O_WRONLY | O_APPEND), read_only(log, O_RDONLY);
  const std::string number = std::to_string(own.descriptor());
  fs::create_symlink("/dev/fd/" + number, folder / "link");
  const ino_t before = status_of(log).st_ino;
  for (const fs::path& path :
       {fs::path("/proc/self/fd/" + number), fs::path("/dev/fd/" + number), folder / "link"}) {
    EXPECT_TRUE(is_stream(path)) << path;
    check_writable(path);
    write_file(path, "new\n");
  }
  EXPECT_EQ(read_file(log), "my old log\nnew\nnew\nnew\n");
  EXPECT_EQ(status_of(log).st_ino, before);
  EXPECT_FALSE(is_stream(log));
  EXPECT_THROW(check_writable("/dev/fd/" + std::to_string(read_only.descriptor())), OutputFileError);
}

/// Bytes that are written next stand behind them too, where the file was not opened to append.
TEST_F(OutputFile, OpenFilesGoOnBehindTheBytes) {
  const OpenFile own(folder / "log", O_WRONLY | O_CREAT);
  const std::vector<std::string_view> parts{"two "};
  write_file("/dev/fd/" + std::to_string(own.descriptor()), "one ");
  EXPECT_TRUE(own.write_all(parts));
  write_file("/dev/fd/" + std::to_string(own.descriptor()), "three");
  EXPECT_EQ(read_file(folder / "log"), "one two three");
}

TEST_F(OutputFile, OpenFilesOfOthersAreAppendedTo) {
  const OpenFile theirs(write("log", "my old log\n"), O_WRONLY);
  const pid_t child = fork();
  if (child == 0) {
    pause();
    _exit(0);
  }
  const std::string path =
      "/proc/" + std::to_string(child) + "/fd/" + std::to_string(theirs.descriptor());  // inherited
  check_writable(path);
  write_file(path, "new\n");
  EXPECT_EQ(read_file(folder / "log"), "my old log\nnew\n");
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

/// Files that cannot be replaced.
class InPlace : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "only root may become another user";
    fs::permissions(folder, fs::perms::all);
  }

  /// Whether `work`, done by nobody, throws no OutputFileError.
  static bool works_for_nobody(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0) {
      if (setgid(65534) != 0 || setuid(65534) != 0) _exit(2);
      try {
        work();
      } catch (const OutputFileError&) {
        _exit(1);
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) < 2) << status;
    return status == 0;
  }

  /// Root's, with this mode, in the folder "to" with that one.
  fs::path make(mode_t folders, mode_t files) const {
    const fs::path file = write("to/a", "a longer old text");
    chmod(file.c_str(), files);
    chmod(at("to").c_str(), folders);
    return file;
  }

  static void expect_written(const fs::path& file) {
    EXPECT_TRUE(works_for_nobody([&] { check_writable(file); }));
    EXPECT_TRUE(works_for_nobody([&] { write_file(file, "new"); }));
    EXPECT_EQ(read_file(file), "new");
    EXPECT_EQ(status_of(file).st_uid, 0u);
    EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), {}), 1);
  }
  static void expect_refused_before(const fs::path& file) {
    EXPECT_FALSE(works_for_nobody([&] { check_writable(file); }));
    EXPECT_FALSE(works_for_nobody([&] { write_file(file, "new"); }));
    EXPECT_EQ(read_file(file), "a longer old text");
  }
};

TEST_F(InPlace, WhereTheFolderIsNotWritable) {
  expect_written(make(0755, 0666));
  expect_refused_before(make(0755, 0644));
  EXPECT_FALSE(works_for_nobody([&] { check_writable(folder / "to" / "new"); }));
}

TEST_F(InPlace, WhereAStickyFolderKeepsAnothersFile) {
  expect_written(make(01777, 0666));
  expect_refused_before(make(01777, 0644));
}

TEST_F(InPlace, WhereAFileOfAnotherWouldChangeHands) {
  expect_written(make(0777, 0666));
}

TEST_F(InPlace, WhereAFileIsMounted) {
  const fs::path file = make(0777, 0666), behind = write("behind", "a longer old text");
  if (mount(behind.c_str(), file.c_str(), nullptr, MS_BIND, nullptr) != 0)
    GTEST_SKIP() << "no right to mount";
  check_writable(file);
  write_file(file, "new");
  EXPECT_EQ(read_file(file), "new");
  umount(file.c_str());
  EXPECT_EQ(read_file(behind), "new");
}

TEST_F(InPlace, StaysAsItWasWhereThereIsNoRoom) {
  fs::create_directory(folder / "to");
  if (mount("stbvh", at("to").c_str(), "tmpfs", 0, "size=64k") != 0) GTEST_SKIP() << "no right to mount";
  const fs::path file = make(0755, 0666);
  EXPECT_FALSE(works_for_nobody([&] { write_file(file, std::string(1 << 20, 'x')); }));
  EXPECT_EQ(read_file(file), "a longer old text");
  expect_written(file);
  umount(at("to").c_str());
}

TEST_F(OutputFile, LinksToWhatIsNotThereYetStayLinks) {
  fs::create_directory(folder / "sub");
  fs::create_symlink("sub/later.json", folder / "first");
  fs::create_symlink(folder / "first", folder / "second");
  check_writable(folder / "second");
  EXPECT_FALSE(fs::exists(folder / "sub" / "later.json"));
  write_file(folder / "second", "one");
  EXPECT_EQ(read_file(folder / "sub" / "later.json"), "one");
  EXPECT_TRUE(fs::is_symlink(folder / "first") && fs::is_symlink(folder / "second"));
}

TEST_F(OutputFile, ALoopOfLinksIsRefusedAndStays) {
  fs::create_symlink(folder / "b", folder / "a");
  fs::create_symlink(folder / "a", folder / "b");
  EXPECT_THROW(check_writable(folder / "a"), OutputFileError);
  EXPECT_THROW(write_file(folder / "a", "x"), OutputFileError);
  EXPECT_TRUE(fs::is_symlink(folder / "a") && fs::is_symlink(folder / "b"));
}

TEST_F(OutputFile, DevicesStayDevicesAlsoBehindLinks) {
  if (!make_device("null", Device::kNull) || !make_device("full", Device::kFull)) {
    GTEST_SKIP() << "only root may make device nodes";
  }
  fs::create_symlink("null", folder / "link");
  for (const char* const name : {"null", "link"}) {
    check_writable(folder / name);
    write_file(folder / name, "x");
  }
  EXPECT_THROW(write_file(folder / "full", "x"), OutputFileError);
  EXPECT_TRUE(fs::is_character_file(folder / "null") && fs::is_character_file(folder / "full"));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 3);
}

TEST_F(OutputFile, PipesAreWrittenTo) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  std::string seen;
  std::thread reader([&] { seen = read_file(folder / "pipe"); });
  check_writable(folder / "pipe");  // the reader goes on waiting
  write_file(folder / "pipe", "text");
  reader.join();
  EXPECT_EQ(seen, "text");
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

/// The reader goes away before all is written: more than a pipe holds.
TEST_F(OutputFile, APipeThatNobodyReadsAnyMoreIsAnErrorAndNotTheEnd) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  std::thread reader([&] { std::ifstream(folder / "pipe").get(); });
  EXPECT_THROW(write_file(folder / "pipe", std::string(1 << 20, 'x')), OutputFileError);
  reader.join();
}

}  // namespace
}  // namespace stbvh::harness
