/// Folders that commands write into.
#pragma once

#include <filesystem>

namespace stbvh::harness {

/// Makes the folder and those above it. Throws UsageError.
void make_folder(const std::filesystem::path& folder);

}  // namespace stbvh::harness
