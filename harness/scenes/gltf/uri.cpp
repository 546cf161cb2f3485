#include "harness/scenes/gltf/uri.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>

namespace stbvh::harness::gltf {
namespace {

int hexadecimal_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/// Whether `text` is `part`, which is in lower case, in any case.
bool is_same(std::string_view text, std::string_view part) {
  return std::equal(text.begin(), text.end(), part.begin(), part.end(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

constexpr std::uint8_t kNoDigit = 64;

/// The value of each character as a digit of base 64, of both alphabets (RFC 4648).
constexpr std::array<std::uint8_t, 256> base64_digits() {
  std::array<std::uint8_t, 256> digits{};
  digits.fill(kNoDigit);
  std::uint8_t value = 0;
  for (unsigned char c = 'A'; c <= 'Z'; ++c) digits[c] = value++;
  for (unsigned char c = 'a'; c <= 'z'; ++c) digits[c] = value++;
  for (unsigned char c = '0'; c <= '9'; ++c) digits[c] = value++;
  digits['+'] = digits['-'] = 62;
  digits['/'] = digits['_'] = 63;
  return digits;
}

std::optional<std::vector<unsigned char>> decode_base64(std::string_view text) {
  static constexpr std::array<std::uint8_t, 256> kDigits = base64_digits();
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  std::vector<unsigned char> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  unsigned count = 0;  // of the bits that wait
  for (const char c : text) {
    const std::uint8_t digit = kDigits[static_cast<unsigned char>(c)];
    if (digit == kNoDigit) return std::nullopt;
    bits = bits << 6 | digit;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<unsigned char>(bits >> count & 0xFF));
  }
  return bytes;
}

}  // namespace

std::string percent_decoded(std::string_view uri) {
  std::string decoded;
  decoded.reserve(uri.size());
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && hexadecimal_digit(uri[i + 1]) >= 0 &&
        hexadecimal_digit(uri[i + 2]) >= 0) {
      decoded.push_back(
          static_cast<char>(hexadecimal_digit(uri[i + 1]) * 16 + hexadecimal_digit(uri[i + 2])));
      i += 2;
    } else {
      decoded.push_back(uri[i]);
    }
  }
  return decoded;
}

bool is_data_uri(std::string_view uri) {
  return is_same(uri.substr(0, 5), "data:");
}

std::optional<std::vector<unsigned char>> decode_data_uri(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  constexpr std::string_view kBase64 = ";base64";
  const std::string_view media_type = uri.substr(0, comma);
  const std::string data = percent_decoded(uri.substr(comma + 1));
  const bool is_base64 = media_type.size() >= kBase64.size() &&
                         is_same(media_type.substr(media_type.size() - kBase64.size()), kBase64);
  if (is_base64) return decode_base64(data);
  return std::vector<unsigned char>(data.begin(), data.end());
}

}  // namespace stbvh::harness::gltf
