/// The lines and words of a text, taken off its front.
#pragma once

#include <algorithm>
#include <string_view>

namespace stbvh::harness {

inline constexpr std::string_view kBlanks = " \t\r\n\v\f";

inline std::string_view without_leading_blanks(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text;
}

/// Takes the first word off `text`; empty at its end.
inline std::string_view take_word(std::string_view& text) {
  text = without_leading_blanks(text);
  const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(word.size());
  return word;
}

/// Takes the first line off `text`, and what ends it.
inline std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

}  // namespace stbvh::harness
