/// Lists in sentences that warn.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

namespace stbvh::harness {

/// The first of some names, and how many more there are.
class NameList {
 public:
  explicit NameList(std::size_t most_named = 5) : most_named_(most_named) {}

  void add(std::string_view name) {
    if (++count_ <= most_named_) text_ += fmt::format("{}{}", text_.empty() ? "" : ", ", name);
  }
  std::size_t count() const { return count_; }
  /// "a, b and 3 more"
  std::string text() const {
    return count_ <= most_named_ ? text_ : fmt::format("{} and {} more", text_, count_ - most_named_);
  }

 private:
  std::size_t most_named_, count_ = 0;
  std::string text_;
};

}  // namespace stbvh::harness
