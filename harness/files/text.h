/// The lines and words of a text, taken off its front.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace stbvh::harness {

inline constexpr std::string_view kBlanks = " \t\r\n\v\f";

inline std::string_view without_leading_blanks(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text;
}

inline std::string_view without_trailing_blanks(std::string_view text) {
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

/// Takes the first word off `text`; empty at its end.
inline std::string_view take_word(std::string_view& text) {
  text = without_leading_blanks(text);
  const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(word.size());
  return word;
}

/// Takes the first line off `text`, and what ends it: LF, CR LF, or CR alone.
inline std::string_view take_line(std::string_view& text) {
  const auto end = std::find_if(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; });
  const std::string_view line = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(line.size());
  text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(text.size(), 1));
  return line;
}

/// A comment begins at a # that begins a word: walk_####.obj and 1.#INF are words.
inline std::string_view without_comment(std::string_view line) {
  std::size_t at = line.find('#');
  while (at != std::string_view::npos && at > 0 && kBlanks.find(line[at - 1]) == std::string_view::npos)
    at = line.find('#', at + 1);
  return line.substr(0, at);
}

}  // namespace stbvh::harness
