/// The lines of OBJ files and their material libraries.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "harness/files/text.h"

namespace stbvh::harness {

/// Hands out the lines of a text, continued ones joined, without comments. But all that stands behind a
/// keyword that names something is the name, as other readers take it: 3ds Max calls materials "Material
/// #25".
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : rest_(text) {}

  /// False at the end. What stands behind the keyword has no blanks around it. Both last until the next call.
  bool next(std::string_view& keyword, std::string_view& arguments) {
    if (rest_.empty()) return false;
    number_ = next_number_;
    std::string_view line = physical_line(), words = line;
    const bool is_naming = names_something(take_word(words));
    line = content(line, is_naming);
    if (is_continued(line)) {
      joined_.clear();
      for (; is_continued(line); line = content(physical_line(), is_naming)) {
        joined_ += line.substr(0, line.size() - 1);
        joined_ += ' ';
      }
      joined_ += line;
      line = joined_;
    }
    keyword = take_word(line);
    arguments = without_leading_blanks(line);
    return true;
  }
  /// Of the line, counted from 1; of a continued one, its first.
  std::size_t number() const { return number_; }

 private:
  static bool names_something(std::string_view keyword) {
    static constexpr std::array<std::string_view, 3> kNaming{"usemtl", "newmtl", "mtllib"};
    return std::find(kNaming.begin(), kNaming.end(), keyword) != kNaming.end();
  }
  static std::string_view content(std::string_view line, bool is_naming) {
    return without_trailing_blanks(is_naming ? line : without_comment(line));
  }
  static bool is_continued(std::string_view line) { return line.ends_with('\\'); }

  std::string_view physical_line() {
    ++next_number_;
    return take_line(rest_);
  }

  std::string_view rest_;
  std::string joined_;
  std::size_t number_ = 0, next_number_ = 1;
};

}  // namespace stbvh::harness
