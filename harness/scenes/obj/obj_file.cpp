#include "harness/scenes/obj/obj_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "harness/scenes/cancellation.h"

namespace stbvh::harness {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";
constexpr std::size_t kMostVertices = std::numeric_limits<std::uint32_t>::max();

/// Hands out the lines of a text, continued ones joined, without comments.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

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
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++next_number_;
    line = line.substr(0, line.find('#'));
    const std::size_t last = line.find_last_not_of(kBlanks);
    return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
  }

  std::string_view rest_;
  std::string joined_;
  std::size_t number_ = 0, next_number_ = 1;
};

/// Takes the first word off `line`; empty at its end.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

class Parser {
 public:
  Parser(const std::filesystem::path& file, std::string_view text) : file_(file), lines_(text) {}

  ObjFile run() {
    std::string_view line;
    while (lines_.next(line)) {
      check_cancelled();
      const std::string_view keyword = take_word(line);
      if (keyword == "v") add_position(line);
      if (keyword == "f") add_face(line);
    }
    if (result_.indices.empty()) throw SceneFileError(fmt::format("{}: it has no faces", file_.string()));
    if (needed_ > result_.positions.size()) {
      throw SceneFileError(fmt::format("{}: line {}: vertex {} is meant, but there are only {}",
                                       file_.string(), needed_line_, needed_, result_.positions.size()));
    }
    return std::move(result_);
  }

 private:
  template <class... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) const {
    throw SceneFileError(fmt::format("{}: line {}: {}", file_.string(), lines_.number(),
                                     fmt::format(text, std::forward<Args>(args)...)));
  }

  float read_number(std::string_view word) const {
    double value = 0;
    const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (end != digits.data() + digits.size() || error == std::errc::invalid_argument)
      fail("\"{}\" is not a number", word);
    if (error != std::errc() || !(std::abs(value) <= double{std::numeric_limits<float>::max()}))
      fail("\"{}\" is not a number that a float can hold", word);
    return static_cast<float>(value);
  }

  /// x y z, then maybe a weight, a color, or both.
  void add_position(std::string_view line) {
    float numbers[7] = {};
    std::size_t count = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (count == std::size(numbers)) fail("a vertex has more than 7 numbers");
      numbers[count++] = read_number(word);
    }
    if (count < 3) fail("a vertex has {} numbers, but at least 3 are needed", count);
    if (result_.positions.size() == kMostVertices) fail("there are more than {} vertices", kMostVertices);
    result_.positions.push_back({numbers[0], numbers[1], numbers[2]});
  }

  /// The vertex of v, v/vt, v//vn or v/vt/vn.
  std::uint32_t read_corner(std::string_view word) {
    const std::string_view digits = word.substr(0, word.find('/'));
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool is_whole = end == digits.data() + digits.size() && error == std::errc();
    if (!is_whole || value == 0 || word.find_first_not_of("+-0123456789/") != std::string_view::npos)
      fail("\"{}\" is not a corner of a face", word);
    const auto count = static_cast<std::int64_t>(result_.positions.size());
    const std::int64_t index = value > 0 ? value - 1 : count + value;
    if (index < 0) fail("vertex {} is meant, but there are only {} so far", value, count);
    if (static_cast<std::uint64_t>(index) >= kMostVertices) fail("there is no vertex {}", value);
    const auto vertex = static_cast<std::uint32_t>(index);
    if (std::size_t{vertex} + 1 > needed_) {  // may still come
      needed_ = std::size_t{vertex} + 1;
      needed_line_ = lines_.number();
    }
    return vertex;
  }

  void add_face(std::string_view line) {
    std::size_t count = 0;
    std::uint32_t first = 0, last = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      const std::uint32_t corner = read_corner(word);
      if (count == 0) first = corner;
      if (count >= 2) result_.indices.insert(result_.indices.end(), {first, last, corner});
      last = corner;
      ++count;
    }
    if (count < 3) fail("a face has {} corners, but at least 3 are needed", count);
  }

  const std::filesystem::path& file_;
  Lines lines_;
  ObjFile result_;
  std::size_t needed_ = 0, needed_line_ = 0;  ///< vertices, and the line that needs so many
};

std::string read_text(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw SceneFileError(fmt::format("{}: it is not a regular file", file.string()));
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) throw SceneFileError(fmt::format("{}: it cannot be opened", file.string()));
  if (size > kMaxSceneFileBytes)
    throw SceneFileError(fmt::format("{}: it has more than {} GB", file.string(), kMaxSceneFileBytes >> 30));
  std::string text(static_cast<std::size_t>(size), '\0');
  stream.read(text.data(), static_cast<std::streamsize>(size));
  if (!stream) throw SceneFileError(fmt::format("{}: it cannot be read", file.string()));
  return text;
}

}  // namespace

ObjFile read_obj_file(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  return Parser(file, text).run();
}

}  // namespace stbvh::harness
