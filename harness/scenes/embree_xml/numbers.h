/// Numbers in text, as Embree's scene files have them.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace stbvh::harness::embree_xml {

/// The words of a text, between white space.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  /// The next one; empty behind the last.
  std::string_view next() {
    constexpr std::string_view kSpace = " \t\r\n\f\v";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kSpace));
    rest_.remove_prefix(word.size());
    return word;
  }

 private:
  std::string_view rest_;
};

/// A whole word as a number, with a sign if there is one; floats may be "inf" and "nan", too, and are
/// infinite beyond their range.
template <class T>
std::optional<T> parse_number(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  T value{};
  const char* const last = word.data() + word.size();
  auto [end, error] = std::from_chars(word.data(), last, value);
  if constexpr (std::is_same_v<T, float>) {
    if (error == std::errc::result_out_of_range) {  // too small, or too large and so infinite
      double wide = 0;
      const auto [wide_end, wide_error] = std::from_chars(word.data(), last, wide);
      if (wide_error == std::errc()) {
        value = static_cast<float>(wide);
        end = wide_end;
        error = std::errc();
      }
    }
  }
  if (word.empty() || error != std::errc() || end != last) return std::nullopt;
  return value;
}

}  // namespace stbvh::harness::embree_xml
