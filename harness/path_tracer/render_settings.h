/// What a picture is made with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "harness/path_tracer/lens_camera.h"

namespace stbvh::harness {

/// Which of the two ways to find light is followed. Each alone is right too, and noisier: tests hold them
/// against each other.
enum class LightSearch { kBoth, kLightsOnly, kScatteringOnly };

/// Some of a picture's rows, so that several machines can render it: the `index`-th of `count` parts that are
/// as high as each other, but for one row.
struct Strip {
  std::size_t index = 0;
  std::size_t count = 1;

  std::size_t top(std::size_t height) const { return height * index / count; }
  std::size_t rows(std::size_t height) const { return height * (index + 1) / count - top(height); }
};

struct RenderSettings {
  std::size_t width = 960;
  std::size_t height = 540;
  Strip strip{};  ///< what is rendered of it
  std::size_t samples_per_pixel = 64;
  std::uint64_t seed = 1;
  std::optional<Camera> camera{};  ///< empty: the scene's own, which also places a sun that no scene brings
  Lens lens;
  Shutter shutter;
  std::size_t max_bounces = 64;  ///< longer paths are cut off; roulette ends nearly all before
  LightSearch light_search = LightSearch::kBoth;
  unsigned threads = 0;  ///< 0: all
};

/// Largest width and height of a picture, and most samples of each pixel.
inline constexpr std::size_t kMaxPictureSide = 16384;
inline constexpr std::size_t kMaxSamplesPerPixel = 65536;

}  // namespace stbvh::harness
