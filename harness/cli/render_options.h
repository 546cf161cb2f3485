/// The options of `render` beside those of its scenes.
#pragma once

#include <CLI/CLI.hpp>

#include "harness/cli/check_options.h"

namespace stbvh::harness {

void add_render_options(CLI::App& command, Arguments& arguments);

/// `scene_camera` with what `options` replace of it; empty where that is nothing. Throws
/// UsageError for a camera that looks nowhere.
std::optional<Camera> chosen_camera(const CameraOptions& options, const Camera& scene_camera);

/// Of --size and --spp. Throw UsageError.
void check_size(Arguments& arguments);
void check_samples(const Arguments& arguments);

/// Throws UsageError.
void check_render_options(Arguments& arguments, const CLI::App& command);

}  // namespace stbvh::harness
