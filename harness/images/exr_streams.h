/// Where OpenEXR writes to and reads from: memory.
#pragma once

#include <Iex.h>
#include <ImfIO.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

namespace stbvh::harness {

/// So that a file appears whole or not at all.
class MemoryOut final : public Imf::OStream {
 public:
  MemoryOut() : OStream("memory") {}
  void write(const char bytes[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    bytes_.resize(std::max(bytes_.size(), at_ + size));
    std::memcpy(bytes_.data() + at_, bytes, size);
    at_ += size;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override { at_ = position; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// So that no read fails but for want of bytes; `bytes` must outlive it.
class MemoryIn final : public Imf::IStream {
 public:
  explicit MemoryIn(std::string_view bytes) : IStream("memory"), bytes_(bytes) {}
  bool read(char target[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ > bytes_.size() || bytes_.size() - at_ < size) throw Iex::InputExc("it ends too early");
    std::memcpy(target, bytes_.data() + at_, size);
    at_ += size;
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override { at_ = position; }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace stbvh::harness
