/// JSON before it is parsed.
#pragma once

#include <string>
#include <string_view>

namespace stbvh::harness::gltf {

/// `text` with blanks for what is inside of "extras" and of extensions that are not read, so that these may
/// be as deep and have as large numbers as they like; all bytes stay where they are. Throws Problem where the
/// rest is nested more than 100 levels deep.
std::string without_what_nothing_reads(std::string_view text);

}  // namespace stbvh::harness::gltf
