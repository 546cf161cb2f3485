/// Whether a cage can be refined.
#pragma once

#include <fmt/core.h>

#include <stdexcept>
#include <utility>

#include "harness/scenes/subdivision/subdivision.h"

namespace stbvh::harness::subdivision {

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw std::invalid_argument(fmt::format(text, std::forward<Args>(args)...));
}

/// Throws std::invalid_argument for everything that is wrong but edges that are not there: only OpenSubdiv
/// makes the edges.
void check_cage(const SubdivisionCage& cage);

}  // namespace stbvh::harness::subdivision
