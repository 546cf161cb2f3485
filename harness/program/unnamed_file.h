/// Files without a name.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace stbvh::harness {

/// Where they lie.
std::string temporary_folder();

/// Gone with the program, however that ends. Programs that it runs inherit it, with the same descriptor.
class UnnamedFile {
 public:
  /// Throws UserError.
  UnnamedFile();
  ~UnnamedFile();
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;

  /// Throws std::system_error.
  void append(std::string_view bytes);
  int descriptor() const { return descriptor_; }
  /// Here, and in programs that inherited it.
  std::filesystem::path path() const;

 private:
  int descriptor_;
};

}  // namespace stbvh::harness
