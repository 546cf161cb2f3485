/// Suggestions for misspelt names.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace stbvh::harness {

/// The one of `names` (not empty) that takes the fewest insertions, deletions and replacements to reach.
std::string_view closest_name(std::string_view misspelt, std::span<const std::string_view> names);

/// "Unknown structure "stbhv": did you mean "stbvh"? (known: a, b, c)"
std::string unknown_name(std::string_view what, std::string_view misspelt,
                         std::span<const std::string_view> names);

}  // namespace stbvh::harness
