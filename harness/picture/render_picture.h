/// Shaded, motion-blurred pictures of scenes, for people to look at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "harness/images/image.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

struct PictureSettings {
  std::size_t width = 960;
  std::size_t height = 540;
  std::size_t samples_per_pixel = 16;
  std::uint64_t seed = 1;
};

/// Largest width and height of a picture.
inline constexpr std::size_t kMaxPictureSide = 16384;

/// Told the fraction done, 0 to 1, never decreasing, one call at a time but from any thread.
using PictureProgress = std::function<void(double fraction)>;

/// Renders `scene` through its camera over the whole shutter [0, 1]: Lambert surfaces under a sun and a sky,
/// each sample at a time of its own. Uses Embree's own triangle geometry. The picture depends on scene and
/// settings only, not on the number of threads. Throws std::invalid_argument for settings, a camera or a mesh
/// that cannot be used, std::runtime_error when Embree fails.
Image render_picture(const Scene& scene, const PictureSettings& settings,
                     const PictureProgress& progress = {});

}  // namespace stbvh::harness
