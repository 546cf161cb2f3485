#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "harness/files/input_file.h"
#include "plugin/files/output_file.h"
#include "tests/harness/temporary_folder.h"

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
