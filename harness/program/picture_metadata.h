/// What a picture's file says of how it was made.
#pragma once

#include <filesystem>
#include <string>

#include "harness/path_tracer/render.h"

namespace stbvh::harness {

/// Adds it to the metadata of `rendering`. `environment`: the file that lit the scene; empty: none.
void add_metadata(const RenderSettings& settings, const std::string& scene, const std::string& structure,
                  const std::filesystem::path& environment, Rendering& rendering);

}  // namespace stbvh::harness
