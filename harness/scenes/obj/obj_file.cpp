#include "harness/scenes/obj/obj_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "harness/files/input_file.h"
#include "harness/files/numbers.h"
#include "harness/scenes/cancellation.h"
#include "harness/scenes/name_list.h"
#include "harness/scenes/obj/obj_lines.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostVertices = std::numeric_limits<std::uint32_t>::max();

class Parser {
 public:
  Parser(const std::filesystem::path& file, std::string_view text) : file_(file), lines_(text) {}

  ObjFile run() {
    std::string_view keyword, arguments;
    while (lines_.next(keyword, arguments)) {
      check_cancelled();
      if (keyword == "v") add_position(arguments);
      if (keyword == "f" || keyword == "fo") add_face(arguments);
      if (keyword == "usemtl") use_material(arguments);
      if (keyword == "mtllib") result_.material_libraries.emplace_back(arguments);
      if (is_other_geometry(keyword)) ++left_out_[std::string(keyword)];
    }
    NameList left_out(left_out_.size());
    for (const auto& [kind, count] : left_out_) left_out.add(fmt::format("{} \"{}\"", count, kind));
    result_.left_out = left_out.text();
    if (result_.face_sizes.empty()) {
      throw SceneFileError(fmt::format("{}: it has no faces{}{}", file_.string(),
                                       result_.left_out.empty() ? "" : ", only ", result_.left_out));
    }
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

  /// Shapes that are not read: of lines, points, free form, and other files. Free form's other keywords say
  /// what these are.
  static bool is_other_geometry(std::string_view keyword) {
    static constexpr std::array<std::string_view, 10> kOthers{"l",   "p",   "curv", "surf", "bzp",
                                                              "bsp", "cdc", "cdp",  "call", "csh"};
    return std::find(kOthers.begin(), kOthers.end(), keyword) != kOthers.end();
  }

  float read_number(std::string_view word) const {
    const auto value = to_number<float>(word);
    if (!value) fail("\"{}\" is not a number", word);
    return *value;
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

  /// Those of the texture and the normal, which are not read: whole numbers, or nothing.
  static bool are_other_indices(std::string_view text) {
    for (int i = 0; i < 2 && text.starts_with('/'); ++i) {
      text.remove_prefix(1);
      const std::string_view digits = text.substr(0, text.find('/'));
      if (!digits.empty() && !to_number<std::int64_t>(digits)) return false;
      text.remove_prefix(digits.size());
    }
    return text.empty();
  }

  /// The vertex of v, v/vt, v//vn or v/vt/vn.
  std::uint32_t read_corner(std::string_view word) {
    const std::size_t end = std::min(word.find('/'), word.size());
    const std::int64_t value = to_number<std::int64_t>(word.substr(0, end)).value_or(0);
    if (value == 0 || !are_other_indices(word.substr(end))) fail("\"{}\" is not a corner of a face", word);
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

  void use_material(std::string_view name) {
    result_.material_runs.push_back({result_.face_sizes.size(), std::string(name)});
  }

  const std::filesystem::path& file_;
  ObjLines lines_;
  ObjFile result_;
  std::map<std::string, std::size_t> left_out_;  ///< how many of each keyword
  std::size_t needed_ = 0, needed_line_ = 0;     ///< vertices, and the line that needs so many
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
