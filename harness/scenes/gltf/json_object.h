/// Reading JSON without pardon: a value of another type or out of range is a Problem, never a default.
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace stbvh::harness::gltf {

/// An object of a JSON document, which must outlive it.
class JsonObject {
 public:
  /// `where` is its place in the document, as in "nodes[3]". Throws Problem where `value` is no object.
  JsonObject(const nlohmann::json& value, std::string where);

  bool has(const char* name) const { return find(name) != nullptr; }
  /// Each returns the member of that name, or, where it is not there, nothing. Throws Problem.
  std::optional<std::size_t> whole_number(const char* name) const;
  std::optional<double> number(const char* name) const;
  std::optional<bool> flag(const char* name) const;
  std::optional<JsonObject> object(const char* name) const;
  std::string text(const char* name) const;
  std::vector<std::size_t> whole_numbers(const char* name) const;
  std::vector<double> numbers(const char* name) const;
  std::vector<std::string> texts(const char* name) const;
  std::vector<JsonObject> objects(const char* name) const;
  /// That many numbers, or none.
  std::vector<double> numbers(const char* name, std::size_t count) const;
  /// The one that must be there.
  std::size_t required_whole_number(const char* name) const;
  /// The object itself as whole numbers by name.
  std::map<std::string, std::size_t> all_whole_numbers() const;
  /// What an extension says of it.
  std::optional<JsonObject> extension(const char* name) const;

  const std::string& where() const { return where_; }

 private:
  const nlohmann::json* find(const char* name) const;
  const nlohmann::json* find_array(const char* name) const;
  std::string place(const std::string& name) const;

  const nlohmann::json* value_;
  std::string where_;
};

}  // namespace stbvh::harness::gltf
