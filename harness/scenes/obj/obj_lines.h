/// The lines of OBJ files and their material libraries.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "harness/files/text.h"

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

 private:
  static bool is_continued(std::string_view line) { return !line.empty() && line.back() == '\\'; }

  std::string_view physical_line() {
    std::string_view line = take_line(rest_);
    ++next_number_;
    line = line.substr(0, line.find('#'));
    const std::size_t last = line.find_last_not_of(kBlanks);
    return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
  }

  std::string_view rest_;
  std::string joined_;
  std::size_t number_ = 0, next_number_ = 1;
};

}  // namespace stbvh::harness
