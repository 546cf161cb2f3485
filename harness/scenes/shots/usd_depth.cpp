#include "harness/scenes/shots/usd_depth.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace stbvh::harness {
namespace {

/// The file's text, read in blocks.
class Text {
 public:
  explicit Text(const InputFile& file) : file_(file) {}

  bool is_at_end() const { return at_ >= file_.size(); }
  char take() {
    if (at_ - first_ >= block_.size()) read_block();
    return block_[at_++ - first_];
  }
  bool take(std::string_view expected) {
    const std::size_t before = at_;
    for (const char c : expected) {
      if (!is_at_end() && take() == c) continue;
      at_ = before;
      if (at_ < first_) read_block();
      return false;
    }
    return true;
  }
  /// Goes behind `end`, or to the end of the text.
  void skip_behind(std::string_view end, bool has_escapes) {
    while (!is_at_end() && !take(end)) {
      if (take() == '\\' && has_escapes && !is_at_end()) take();
    }
  }

 private:
  void read_block() {
    constexpr std::size_t kBlock = 1 << 16;
    first_ = at_;
    block_.resize(std::min(kBlock, file_.size() - at_));
    file_.read(first_, block_);
  }

  const InputFile& file_;
  std::size_t at_ = 0, first_ = 0;
  std::string block_;
};

/// Behind a quote or the sign of a file's name, which stand alone or in threes.
void skip_quoted(Text& text, char quote) {
  const std::string one(1, quote), three(3, quote);
  const bool has_escapes = quote != '@';
  if (!text.take(one)) {
    text.skip_behind(one, has_escapes);
  } else if (text.take(one)) {
    text.skip_behind(three, has_escapes);
  }
}

}  // namespace

bool is_nested_too_deeply(const InputFile& file) {
  Text text(file);
  if (!text.take("#")) return false;
  text.skip_behind("\n", false);
  for (int depth = 0; !text.is_at_end();) {
    const char c = text.take();
    switch (c) {
      case '(':
      case '[':
      case '{':
        if (++depth > kMaxUsdDepth) return true;
        break;
      case ')':
      case ']':
      case '}':
        --depth;
        break;
      case '"':
      case '\'':
      case '@':
        skip_quoted(text, c);
        break;
      case '#':
        text.skip_behind("\n", false);
        break;
      case '/':
        if (text.take("/")) {
          text.skip_behind("\n", false);
        } else if (text.take("*")) {
          text.skip_behind("*/", false);
        }
        break;
      default:
        break;
    }
  }
  return false;
}

}  // namespace stbvh::harness
