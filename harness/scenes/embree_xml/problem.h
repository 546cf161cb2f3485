/// How the parts of the Embree XML reader say what is wrong with a file, and what they leave out of it.
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <functional>
#include <pugixml.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace stbvh::harness::embree_xml {

/// Told one sentence for each thing that a scene is read without.
using Warn = std::function<void(const std::string& warning)>;

/// One sentence without the file's name and line, which read_file() puts in front.
struct Problem : std::runtime_error {
  explicit Problem(const std::string& text, std::ptrdiff_t at = -1) : std::runtime_error(text), offset(at) {}
  std::ptrdiff_t offset;  ///< in the file, in bytes; negative: it concerns no particular place
};

/// For what is wrong at `node`.
template <class... Args>
[[noreturn]] void fail(pugi::xml_node node, fmt::format_string<Args...> text, Args&&... args) {
  throw Problem(fmt::format(text, std::forward<Args>(args)...), node.offset_debug());
}

}  // namespace stbvh::harness::embree_xml
