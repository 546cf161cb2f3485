/// Words as numbers, as scene files have them.
#pragma once

#include <charconv>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace stbvh::harness {

/// What Visual Studio's C library wrote before 2015 for a number that is not finite: "1.#INF", "-1.#IND",
/// "1.#QNAN", with zeros behind it, or rounded as if it were digits: "1.#J".
inline std::optional<float> old_non_finite_number(std::string_view word) {
  const bool is_negative = word.starts_with('-');
  if (is_negative) word.remove_prefix(1);
  if (!word.starts_with("1.#") || word.size() == 3 || word[3] < 'A' || word[3] > 'Z') return std::nullopt;
  using Limits = std::numeric_limits<float>;
  if (!word.starts_with("1.#INF")) return Limits::quiet_NaN();
  return is_negative ? -Limits::infinity() : Limits::infinity();
}

/// A whole word as a number, with a sign if there is one. Floats may be "inf", "nan" and "-nan(ind)", too;
/// they are infinite above their range, and 0 below it.
template <class T>
std::optional<T> to_number(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  T value{};
  const char* const last = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), last, value);
  const bool is_whole = !word.empty() && end == last;
  if (is_whole && error == std::errc()) return value;
  if constexpr (std::is_same_v<T, float>) {
    if (is_whole && error == std::errc::result_out_of_range)
      return std::strtof(std::string(word).c_str(), nullptr);
    return old_non_finite_number(word);
  }
  return std::nullopt;
}

}  // namespace stbvh::harness
