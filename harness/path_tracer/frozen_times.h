/// Motion blur without motion: the mean of pictures of scenes at rest.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>

#include "harness/images/layered_image.h"
#include "harness/path_tracer/render_settings.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Told how many times are done.
using FrozenProgress = std::function<void(std::size_t done)>;

/// R, G and B of the mean of `count` (above 0) renderings of frozen scenes with one sample for each pixel,
/// each through a structure `structure` of its own. The times are drawn one from each of `count` equal parts
/// of [0, 1]; times and samples depend on the settings' seed. A box shutter over [0, 1], whatever the
/// settings say. Once `stop` is true nothing more is rendered, and there is no mean. Throws as render() and
/// build_structure() do.
std::optional<LayeredImage> mean_of_frozen_times(const Scene& scene, std::string_view structure,
                                                 const RenderSettings& settings, std::size_t count,
                                                 const FrozenProgress& progress = {},
                                                 const std::atomic<bool>* stop = nullptr);

}  // namespace stbvh::harness
