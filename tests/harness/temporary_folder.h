/// Folders and files of tests.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace stbvh::harness {

namespace fs = std::filesystem;

inline std::string read_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// As they stand in memory.
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// A new folder, which is gone with its owner.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_(made()) {}
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  static fs::path made() {
    std::string name = (fs::temp_directory_path() / "stbvh_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw fs::filesystem_error(name, {errno, std::generic_category()});
    return name;
  }

  fs::path path_;
};

/// A folder for all tests of a suite, whose files take long to make.
class SharedFolderTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { folder() = std::make_unique<TemporaryFolder>(); }
  static void TearDownTestSuite() { folder().reset(); }

  static std::string path(const std::string& name) { return (folder()->path() / name).string(); }

 private:
  static std::unique_ptr<TemporaryFolder>& folder() {
    static std::unique_ptr<TemporaryFolder> of_all;
    return of_all;
  }
};

/// A folder for each test.
class TemporaryFolderTest : public testing::Test {
 protected:
  /// The file, also in folders that are not there yet.
  fs::path write(const std::string& name, std::string_view bytes) const {
    fs::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }

  std::string at(const std::string& name) const { return (folder / name).string(); }

  /// Nodes of the test's own: what replaces a device by a file must not find the machine's.
  enum class Device : unsigned { kNull = 3, kFull = 7 };
  /// False where only root may make them.
  bool make_device(const std::string& name, Device device) const {
    return mknod(at(name).c_str(), S_IFCHR | 0666, makedev(1, static_cast<unsigned>(device))) == 0;
  }

 private:
  const TemporaryFolder owner_;

 protected:
  const fs::path& folder = owner_.path();
};

}  // namespace stbvh::harness
