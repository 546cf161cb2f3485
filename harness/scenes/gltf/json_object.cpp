#include "harness/scenes/gltf/json_object.h"

#include <string_view>
#include <utility>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

using nlohmann::json;

// Places are functions: they are put into words only where something is wrong.

/// `value` for a message: on one line, and short.
std::string shown(const json& value) {
  if (value.is_structured()) return value.is_array() ? "an array" : "an object";
  constexpr std::size_t kMostCharacters = 40;
  const std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  return text.size() <= kMostCharacters ? text : text.substr(0, kMostCharacters) + "...";
}

template <class Place>
std::size_t to_whole_number(const json& value, const Place& place) {
  if (!value.is_number_unsigned())
    fail("{} is {}, which is not a whole number from 0 on", place(), shown(value));
  return value.get<std::size_t>();
}

template <class Place>
double to_number(const json& value, const Place& place) {
  if (!value.is_number()) fail("{} is {}, which is not a number", place(), shown(value));
  return value.get<double>();
}

template <class Place>
std::string to_text(const json& value, const Place& place) {
  if (!value.is_string()) fail("{} is {}, which is not text", place(), shown(value));
  return value.get<std::string>();
}

/// `convert(value, place of the value)` of each element of `array`, which may be null.
template <class T, class Place, class Convert>
std::vector<T> elements(const json* array, const Place& place, const Convert& convert) {
  std::vector<T> result;
  if (array == nullptr) return result;
  result.reserve(array->size());
  const auto place_of_element = [&] { return fmt::format("{}[{}]", place(), result.size()); };
  for (const json& value : *array) result.push_back(convert(value, place_of_element));
  return result;
}

}  // namespace

JsonObject::JsonObject(const json& value, std::string where) : value_(&value), where_(std::move(where)) {
  if (!value.is_object()) fail("{} is {}, which is not an object", where_, shown(value));
}

std::string JsonObject::place(const std::string& name) const {
  return where_.empty() ? name : fmt::format("{}.{}", where_, name);
}

const json* JsonObject::find(const char* name) const {
  const auto found = value_->find(name);
  return found == value_->end() ? nullptr : &*found;
}

const json* JsonObject::find_array(const char* name) const {
  const json* const array = find(name);
  if (array != nullptr && !array->is_array())
    fail("{} is {}, which is not an array", place(name), shown(*array));
  return array;
}

std::optional<std::size_t> JsonObject::whole_number(const char* name) const {
  const json* const value = find(name);
  if (value == nullptr) return std::nullopt;
  return to_whole_number(*value, [&] { return place(name); });
}

std::size_t JsonObject::required_whole_number(const char* name) const {
  const auto value = whole_number(name);
  if (!value) fail("{} has no {}", where_, name);
  return *value;
}

std::optional<double> JsonObject::number(const char* name) const {
  const json* const value = find(name);
  if (value == nullptr) return std::nullopt;
  return to_number(*value, [&] { return place(name); });
}

std::optional<bool> JsonObject::flag(const char* name) const {
  const json* const value = find(name);
  if (value == nullptr) return std::nullopt;
  if (!value->is_boolean()) fail("{} is {}, which is neither true nor false", place(name), shown(*value));
  return value->get<bool>();
}

std::optional<JsonObject> JsonObject::object(const char* name) const {
  const json* const value = find(name);
  if (value == nullptr) return std::nullopt;
  return JsonObject(*value, place(name));
}

std::string JsonObject::text(const char* name) const {
  const json* const value = find(name);
  return value == nullptr ? std::string() : to_text(*value, [&] { return place(name); });
}

std::vector<std::size_t> JsonObject::whole_numbers(const char* name) const {
  return elements<std::size_t>(
      find_array(name), [&] { return place(name); },
      [](const json& value, const auto& where) { return to_whole_number(value, where); });
}

std::vector<double> JsonObject::numbers(const char* name) const {
  return elements<double>(
      find_array(name), [&] { return place(name); },
      [](const json& value, const auto& where) { return to_number(value, where); });
}

std::vector<std::string> JsonObject::texts(const char* name) const {
  return elements<std::string>(
      find_array(name), [&] { return place(name); },
      [](const json& value, const auto& where) { return to_text(value, where); });
}

std::vector<JsonObject> JsonObject::objects(const char* name) const {
  return elements<JsonObject>(
      find_array(name), [&] { return place(name); },
      [](const json& value, const auto& where) { return JsonObject(value, where()); });
}

std::vector<double> JsonObject::numbers(const char* name, std::size_t count) const {
  std::vector<double> values = numbers(name);
  if (has(name) && values.size() != count)
    fail("{} has {} numbers instead of {}", place(name), values.size(), count);
  return values;
}

std::map<std::string, std::size_t> JsonObject::all_whole_numbers() const {
  std::map<std::string, std::size_t> result;
  for (const auto& [name, value] : value_->items())
    result[name] = to_whole_number(value, [&, &key = name] { return place(key); });
  return result;
}

std::optional<JsonObject> JsonObject::extension(const char* name) const {
  const auto extensions = object("extensions");
  return extensions ? extensions->object(name) : std::nullopt;
}

}  // namespace stbvh::harness::gltf
