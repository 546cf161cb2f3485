/// The command line that makes a picture of the preview again.
#pragma once

#include <array>
#include <string>

#include "harness/path_tracer/render_settings.h"
#include "harness/preview/shown_picture.h"
#include "harness/program/scene_options.h"

namespace stbvh::harness {

/// `stbvh-ab render ...` of the scene `scene`, made as `options` say, through `structures` (the second may be
/// empty), with the size, samples, camera, lens and shutter of `settings`.
std::string render_command(const MakingOptions& options, const std::string& scene,
                           const std::array<std::string, kSlots>& structures, const RenderSettings& settings);

}  // namespace stbvh::harness
