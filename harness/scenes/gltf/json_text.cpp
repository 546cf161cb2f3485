#include "harness/scenes/gltf/json_text.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "harness/scenes/gltf/extensions.h"
#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

constexpr std::size_t kMaxDepth = 100;
constexpr std::string_view kBlanks = " \t\r\n", kOfNumbers = "+-.0123456789eE";

/// Walks through text that may be broken: the parser finds out.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) {}

  std::string walk() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"') {
        read_string();
      } else if (c == '[' || c == '{') {
        open();
      } else {
        if ((c == ']' || c == '}') && depth_ > 0) --depth_;
        ++at_;
      }
    }
    return std::move(text_);
  }

 private:
  void open() {
    if (++depth_ > kMaxDepth) fail("its JSON is nested more than {} levels deep", kMaxDepth);
    has_extensions_[depth_] = are_extensions_;
    are_extensions_ = false;
    ++at_;
  }

  /// What may be a name: then what follows its colon is emptied if it is not read.
  void read_string() {
    const std::size_t begin = at_ + 1;
    at_ = end_of_string(at_);
    const std::string_view name = std::string_view(text_).substr(begin, at_ - begin);
    const std::size_t colon = text_.find_first_not_of(kBlanks, ++at_);
    if (colon >= text_.size() || text_[colon] != ':') return;
    at_ = std::min(text_.find_first_not_of(kBlanks, colon + 1), text_.size());
    if (name == "extras" || (has_extensions_[depth_] && !is_looked_into(name))) {
      empty_value();
    } else {
      are_extensions_ = name == "extensions" && at_ < text_.size() && text_[at_] == '{';
    }
  }

  /// Of its closing quote, or of the text.
  std::size_t end_of_string(std::size_t quote) const {
    for (std::size_t i = quote + 1; i < text_.size(); ++i) {
      if (text_[i] == '"') return i;
      if (text_[i] == '\\') ++i;
    }
    return text_.size();
  }

  /// An object or an array becomes empty, a number 0; what else there is may stay.
  void empty_value() {
    if (at_ == text_.size()) return;
    const std::size_t begin = at_ + 1;
    const char first = text_[at_];
    if (first == '[' || first == '{') {
      at_ = end_of_structure(at_);
      blank(begin, at_);
      if (at_ < text_.size()) ++at_;  // its brackets are not counted
    } else if (const std::size_t end = text_.find_first_not_of(kOfNumbers, at_); end != at_) {
      at_ = std::min(end, text_.size());
      text_[begin - 1] = '0';
      blank(begin, at_);
    }
  }

  void blank(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) text_[i] = ' ';
  }

  /// Of the bracket that closes the one at `begin`, or of the text.
  std::size_t end_of_structure(std::size_t begin) const {
    std::size_t depth = 0;
    for (std::size_t i = begin; i < text_.size(); ++i) {
      const char c = text_[i];
      if (c == '"') i = end_of_string(i);
      if (c == '[' || c == '{') ++depth;
      if ((c == ']' || c == '}') && --depth == 0) return i;
    }
    return text_.size();
  }

  std::string text_;
  std::size_t at_ = 0, depth_ = 0;
  std::array<bool, kMaxDepth + 1> has_extensions_{};  ///< whether the names at each depth are extensions'
  bool are_extensions_ = false;                       ///< likewise, of the object that opens next
};

}  // namespace

std::string without_what_nothing_reads(std::string_view text) {
  return Walker(text).walk();
}

}  // namespace stbvh::harness::gltf
