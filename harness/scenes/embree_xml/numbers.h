/// Numbers in text, as Embree's scene files have them.
#pragma once

#include <charconv>
#include <optional>
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
