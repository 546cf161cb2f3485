/// URIs of buffers: names of files, or the data itself (RFC 2397).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stbvh::harness::gltf {

/// %20 and the like as the characters that they stand for.
std::string percent_decoded(std::string_view uri);

bool is_data_uri(std::string_view uri);

/// Whether it begins as in "http://" or "file:": no name of a file beside another.
bool has_scheme(std::string_view uri);

/// The bytes in a data URI of any media type; nothing where it is broken.
std::optional<std::vector<unsigned char>> decode_data_uri(std::string_view uri);

}  // namespace stbvh::harness::gltf
