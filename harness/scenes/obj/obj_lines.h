/// The lines and words of OBJ files and their material libraries.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace stbvh::harness {

/// Hands out the lines of a text, continued ones joined, without comments.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : rest_(text) {}

  /// False at the end. The line lasts until the next call.
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    number_ = next_number_;
    line = physical_line();
    if (!is_continued(line)) return true;
    joined_.clear();
    while (is_continued(line)) {
      joined_ += line.substr(0, line.size() - 1);
      joined_ += ' ';
      line = physical_line();
    }
    joined_ += line;
    line = joined_;
    return true;
  }
  /// Of the line, counted from 1; of a continued one, its first.
  std::size_t number() const { return number_; }

  static constexpr std::string_view kBlanks = " \t\r\v\f";

 private:
  static bool is_continued(std::string_view line) { return !line.empty() && line.back() == '\\'; }

  std::string_view physical_line() {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++next_number_;
    line = line.substr(0, line.find('#'));
    const std::size_t last = line.find_last_not_of(kBlanks);
    return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
  }

  std::string_view rest_;
  std::string joined_;
  std::size_t number_ = 0, next_number_ = 1;
};

inline std::string_view without_leading_blanks(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(ObjLines::kBlanks), line.size()));
  return line;
}

/// Takes the first word off `line`; empty at its end.
inline std::string_view take_word(std::string_view& line) {
  line = without_leading_blanks(line);
  const std::string_view word = line.substr(0, line.find_first_of(ObjLines::kBlanks));
  line.remove_prefix(word.size());
  return word;
}

}  // namespace stbvh::harness
