/// Which of glTF's extensions are read, and which may be left out.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace stbvh::harness::gltf {

inline constexpr std::array<std::string_view, 2> kMeshopt = {"EXT_meshopt_compression",
                                                             "KHR_meshopt_compression"};

/// Whether anything inside an extension of that name matters.
bool is_looked_into(std::string_view name);

/// Throws Problem for those without which geometry or motion would be wrong.
void check_required_extensions(const std::vector<std::string>& names);

/// Those of `names` that are not read, each once.
std::vector<std::string> unread_extensions(const std::vector<std::string>& names);

}  // namespace stbvh::harness::gltf
