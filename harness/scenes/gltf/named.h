/// Parts of a glTF file that are asked for by name or number.
#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {

/// The number that `text` is, all of it.
inline std::optional<std::size_t> parse_index(std::string_view text) {
  std::size_t index = 0;
  const auto [stopped, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc() || stopped != text.data() + text.size()) return std::nullopt;
  return index;
}

/// The one of `parts` whose name or, failing that, index is `name_or_index`; each is called a `kind` in the
/// Problem where there is none.
template <class Part>
const Part& find_named(const std::vector<Part>& parts, const std::string& name_or_index, const char* kind) {
  for (const Part& part : parts) {
    if (part.name == name_or_index) return part;
  }
  const auto index = parse_index(name_or_index);
  if (index && *index < parts.size()) return parts[*index];
  constexpr std::size_t kMostNamed = 20;
  std::string list;
  for (std::size_t i = 0; i < parts.size() && i < kMostNamed; ++i)
    list += fmt::format("{}{} '{}'", i == 0 ? "" : ", ", i, parts[i].name);
  if (parts.size() > kMostNamed) list += ", ...";
  if (parts.empty()) fail("it has no {} '{}', for it has none at all", kind, name_or_index);
  fail("it has no {} '{}'; its {}s are {}", kind, name_or_index, kind, list);
}

}  // namespace stbvh::harness::gltf
