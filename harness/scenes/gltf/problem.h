/// How the parts of the glTF reader say what is wrong with a file.
#pragma once

#include <fmt/core.h>

#include <stdexcept>
#include <utility>

namespace stbvh::harness::gltf {

/// One sentence without the file's name, which load_gltf() puts in front.
struct Problem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw Problem(fmt::format(text, std::forward<Args>(args)...));
}

}  // namespace stbvh::harness::gltf
