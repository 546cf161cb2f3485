/// Which of glTF's extensions are read, and which may be left out.
#pragma once

#include <string>
#include <vector>

namespace stbvh::harness::gltf {

/// Throws Problem for those without which geometry or motion would be wrong.
void check_required_extensions(const std::vector<std::string>& names);

/// Those of `names` that are not read, each once.
std::vector<std::string> unread_extensions(const std::vector<std::string>& names);

}  // namespace stbvh::harness::gltf
