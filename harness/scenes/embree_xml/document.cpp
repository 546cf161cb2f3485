#include "harness/scenes/embree_xml/document.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <system_error>

#include "harness/files/numbers.h"
#include "harness/files/text.h"
#include "harness/scenes/cancellation.h"
#include "harness/scenes/embree_xml/problem.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::embree_xml {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNumbersBetweenChecks = 4096;  // for cancellation

std::uint64_t count_attribute(pugi::xml_node node, const char* name) {
  const std::string_view text = node.attribute(name).value();
  const auto count = to_number<std::uint64_t>(text);
  if (!count) fail(node, "the {} of its <{}> is \"{}\", not a number", name, node.name(), text);
  return *count;
}

bool is_binary(pugi::xml_node array) {
  return !array.attribute("ofs").empty();
}

}  // namespace

std::string text_of(pugi::xml_node node) {
  std::string text;
  for (const pugi::xml_node child : node.children()) {
    if (child.type() != pugi::node_pcdata && child.type() != pugi::node_cdata) continue;
    text += child.value();
    text += ' ';
  }
  return text;
}

std::vector<float> float_attribute(pugi::xml_node node, const char* name, std::size_t count) {
  const char* const text = node.attribute(name).value();
  std::string_view rest = text;
  std::vector<float> values;
  for (auto word = take_word(rest); !word.empty(); word = take_word(rest)) {
    const auto value = to_number<float>(word);
    values.push_back(value.value_or(std::nanf("")));
  }
  const bool all_finite = std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
  if (values.size() != count || !all_finite)
    fail(node, "the {} of its <{}> is \"{}\", not {} number{}", name, node.name(), text, count,
         count == 1 ? "" : "s");
  return values;
}

Document::Document(const fs::path& file) : file_(file), text_(read_whole_text(file, kMaxSceneTextBytes)) {
  const pugi::xml_parse_result result = xml_.load_buffer(text_.data(), text_.size());
  is_utf8_ = result.encoding == pugi::encoding_utf8;
  if (result.status == pugi::status_out_of_memory) throw std::bad_alloc();
  if (!result) {
    std::string what = result.description();
    if (!what.empty())
      what.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(what.front())));
    throw Problem(fmt::format("it is not XML{}: {}", place(result.offset), what));
  }
  scene_ = xml_.document_element();
  if (std::string_view(scene_.name()) != "scene")
    fail(scene_, "its root element is <{}>, not <scene>", scene_.name());
}

std::string Document::place(std::ptrdiff_t offset) const {
  if (offset < 0 || !is_utf8_) return {};
  const auto end = text_.begin() + std::min(offset, static_cast<std::ptrdiff_t>(text_.size()));
  return fmt::format(", line {}", 1 + std::count(text_.begin(), end, '\n'));
}

void Document::open_binary(pugi::xml_node array) {
  if (binary_) return;
  fs::path beside = file_;
  beside.replace_extension(".bin");
  fs::path appended = file_;
  appended += ".bin";
  std::error_code error;
  for (const fs::path& path : {beside, appended}) {
    if (fs::status(path, error).type() == fs::file_type::not_found) continue;
    try {
      binary_.emplace(path, kMaxSceneFileBytes);
    } catch (const InputFileError& problem) {
      fail(array, "\"{}\" {}", path.string(), problem.what());
    }
    binary_path_ = path;
    return;
  }
  fail(array, "its <{}> stands in a binary file, but there is neither \"{}\" nor \"{}\"", array.name(),
       beside.string(), appended.string());
}

void Document::read_binary(pugi::xml_node array, std::size_t element_bytes, std::vector<char>& bytes) {
  const std::uint64_t offset = count_attribute(array, "ofs");
  const std::uint64_t size = count_attribute(array, array.attribute("size").empty() ? "num" : "size");
  if (size == 0) return;
  open_binary(array);
  if (offset > binary_->size() || size > (binary_->size() - offset) / element_bytes)
    fail(array, "its <{}> needs {} elements of {} bytes from byte {} on, but \"{}\" has only {} bytes",
         array.name(), size, element_bytes, offset, binary_path_.string(), binary_->size());
  bytes_read_ += size * element_bytes;
  if (bytes_read_ > kMaxSceneFileBytes)
    fail(array, "its arrays need more than {} GB", kMaxSceneFileBytes >> 30);
  bytes.resize(size * element_bytes);
  try {
    binary_->read(offset, bytes);
  } catch (const InputFileError& problem) {
    fail(array, "\"{}\" {}", binary_path_.string(), problem.what());
  }
}

template <class T>
std::vector<T> Document::numbers(pugi::xml_node array, std::size_t per_element) {
  std::vector<T> values;
  if (!array) return values;
  if (is_binary(array)) {
    std::vector<char> bytes;
    read_binary(array, per_element * sizeof(T), bytes);
    values.resize(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  for (const pugi::xml_node child : array.children()) {
    if (child.type() != pugi::node_pcdata && child.type() != pugi::node_cdata) continue;
    std::string_view rest = child.value();
    for (auto word = take_word(rest); !word.empty(); word = take_word(rest)) {
      const auto value = to_number<T>(word);
      if (!value) fail(array, "its <{}> has \"{}\" among its numbers", array.name(), word.substr(0, 40));
      values.push_back(*value);
      if (values.size() % kNumbersBetweenChecks == 0) check_cancelled();
    }
  }
  if (values.size() % per_element != 0)
    fail(array, "its <{}> has {} numbers, not a multiple of {}", array.name(), values.size(), per_element);
  return values;
}

std::vector<float> Document::floats(pugi::xml_node array, std::size_t per_element) {
  return numbers<float>(array, per_element);
}

std::vector<std::uint32_t> Document::integers(pugi::xml_node array, std::size_t per_element) {
  return numbers<std::uint32_t>(array, per_element);
}

VertexBuffer Document::positions(pugi::xml_node array) {
  const std::vector<float> values = floats(array, 3);
  VertexBuffer buffer(values.size() / 3);
  for (std::size_t i = 0; i < buffer.size(); ++i)
    buffer[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  return buffer;
}

std::vector<Affine> Document::affine_columns(pugi::xml_node array) {
  if (!is_binary(array)) fail(array, "its <{}> must stand in the binary file", array.name());
  const std::vector<float> values = floats(array, 12);
  std::vector<Affine> maps(values.size() / 12);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) fail(array, "its <{}> has numbers that are not finite", array.name());
    maps[i / 12].row[i % 3][i % 12 / 3] = static_cast<double>(values[i]);
  }
  return maps;
}

}  // namespace stbvh::harness::embree_xml
