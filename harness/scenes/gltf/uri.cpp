#include "harness/scenes/gltf/uri.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "harness/files/text.h"

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

/// Where `mark` is for the first time outside quotes; npos if it is not.
std::size_t find_unquoted(std::string_view text, char mark) {
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') is_quoted = !is_quoted;
    if (text[i] == mark && !is_quoted) return i;
  }
  return std::string_view::npos;
}

std::optional<std::vector<unsigned char>> decode_base64(std::string text) {
  static constexpr std::array<std::uint8_t, 256> kDigits = base64_digits();
  constexpr std::string_view kAsciiWhitespace = " \t\r\n\f";
  std::erase_if(text, [&](char c) { return kAsciiWhitespace.find(c) != std::string_view::npos; });
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.pop_back();
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

bool has_scheme(std::string_view uri) {
  return is_same(uri.substr(0, 5), "file:") || uri.find("://") < uri.find_first_of("/?#%");
}

std::optional<std::vector<unsigned char>> decode_data_uri(std::string_view uri) {
  constexpr std::string_view kBase64 = "base64";
  uri.remove_prefix(uri.find(':') + 1);
  const std::size_t comma = find_unquoted(uri, ',');
  if (comma == std::string_view::npos) return std::nullopt;
  bool is_base64 = false;
  std::string_view parameters = uri.substr(0, comma);  // behind the media type
  for (std::size_t end = find_unquoted(parameters, ';'); end != std::string_view::npos;
       end = find_unquoted(parameters, ';')) {
    parameters.remove_prefix(end + 1);
    const std::string_view parameter =
        without_leading_blanks(without_trailing_blanks(parameters.substr(0, find_unquoted(parameters, ';'))));
    if (is_base64) return std::nullopt;  // which is the last
    is_base64 = is_same(parameter, kBase64);
    if (!is_base64 && is_same(parameter.substr(0, kBase64.size()), kBase64)) return std::nullopt;
  }
  std::string data = percent_decoded(uri.substr(comma + 1));
  if (is_base64) return decode_base64(std::move(data));
  return std::vector<unsigned char>(data.begin(), data.end());
}

}  // namespace stbvh::harness::gltf
