/// What a picture's file says of how it was made.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/path_tracer/render.h"

namespace stbvh::harness {

/// Name and value, as LayeredImage has them.
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// What decides the pixels of a picture of `scene`, whose scene_hash() is `hash`, apart from which of its
/// rows it has: pictures with the same of this have the same bits. `environment`: the file that lit the
/// scene; empty: none.
Metadata making_metadata(const RenderSettings& settings, const Scene& scene, const std::string& hash,
                         const std::string& structure, const std::filesystem::path& environment);

/// Adds what is known of a rendering made by `settings` once it is there.
void add_outcome(const RenderSettings& settings, Rendering& rendering);

/// "2/4" of a strip; "1/1" of a whole picture.
std::string strip_text(const Strip& strip);

/// The value of `name`; empty where there is none.
std::string value_of(const Metadata& metadata, std::string_view name);

/// The first name whose value in `metadata` is not that in `wanted`; empty: all of `wanted` is there.
std::string first_difference(const Metadata& wanted, const Metadata& metadata);

}  // namespace stbvh::harness
