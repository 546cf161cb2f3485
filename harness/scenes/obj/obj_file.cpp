#include "harness/scenes/obj/obj_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "harness/files/input_file.h"
#include "harness/scenes/cancellation.h"
#include "harness/scenes/obj/obj_lines.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostVertices = std::numeric_limits<std::uint32_t>::max();

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
      if (keyword == "usemtl") use_material(line);
      if (keyword == "mtllib") result_.material_libraries.emplace_back(without_leading_blanks(line));
    }
    if (result_.face_sizes.empty()) throw SceneFileError(fmt::format("{}: it has no faces", file_.string()));
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

  /// A number beyond a float's range is infinite, as in C.
  float read_number(std::string_view word) const {
    double value = 0;
    const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (end != digits.data() + digits.size() || error == std::errc::invalid_argument)
      fail("\"{}\" is not a number", word);
    if (error == std::errc::result_out_of_range) value = std::strtod(std::string(digits).c_str(), nullptr);
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
    std::uint32_t count = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line), ++count)
      result_.corners.push_back(read_corner(word));
    if (count < 3) fail("a face has {} corners, but at least 3 are needed", count);
    result_.face_sizes.push_back(count);
  }

  void use_material(std::string_view line) {
    result_.material_runs.push_back({result_.face_sizes.size(), std::string(without_leading_blanks(line))});
  }

  const std::filesystem::path& file_;
  ObjLines lines_;
  ObjFile result_;
  std::size_t needed_ = 0, needed_line_ = 0;  ///< vertices, and the line that needs so many
};

}  // namespace

ObjFile read_obj_file(const std::filesystem::path& file) {
  try {
    return Parser(file, read_text_file(file, kMaxSceneTextBytes)).run();
  } catch (const InputFileError& error) {
    throw SceneFileError(fmt::format("{}: it {}", file.string(), error.what()));
  }
}

}  // namespace stbvh::harness
