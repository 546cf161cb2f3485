/// Numbers in text, as Embree's scene files have them.
#pragma once

#include <charconv>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace stbvh::harness::embree_xml {

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
      value = static_cast<float>(std::strtod(std::string(word.data(), end).c_str(), nullptr));
      error = std::errc();
    }
  }
  if (word.empty() || error != std::errc() || end != last) return std::nullopt;
  return value;
}

}  // namespace stbvh::harness::embree_xml
