#include "harness/path_tracer/render.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "harness/path_tracer/path_tracer.h"
#include "harness/path_tracer/pixel_layers.h"
#include "harness/path_tracer/tiles.h"

namespace stbvh::harness {
namespace {

/// What tiles add to, one at a time.
class Tally {
 public:
  Tally(Rendering& rendering, std::size_t tiles, const RenderProgress& progress)
      : rendering_(rendering), tiles_(tiles), progress_(progress) {}

  void add_tile(std::uint64_t rays, std::uint64_t not_finite) {
    const std::lock_guard lock(mutex_);
    rendering_.rays += rays;
    rendering_.not_finite += not_finite;
    ++done_;
    if (progress_) progress_(static_cast<double>(done_) / static_cast<double>(tiles_));
  }
  bool is_complete() const { return done_ == tiles_; }

 private:
  Rendering& rendering_;
  std::size_t tiles_, done_ = 0;
  const RenderProgress& progress_;
  std::mutex mutex_;
};

}  // namespace

void check_picture(const RenderSettings& settings) {
  const auto bad_side = [](std::size_t side) { return side == 0 || side > kMaxPictureSide; };
  if (bad_side(settings.width) || bad_side(settings.height)) {
    throw std::invalid_argument(
        fmt::format("A picture of {} x {} pixels cannot be made: each side is 1 to {}.", settings.width,
                    settings.height, kMaxPictureSide));
  }
  if (settings.strip.index >= settings.strip.count || settings.strip.count > settings.height) {
    throw std::invalid_argument(fmt::format("A picture of {} rows has no strip {} of {}.", settings.height,
                                            settings.strip.index + 1, settings.strip.count));
  }
  if (settings.samples_per_pixel == 0 || settings.samples_per_pixel > kMaxSamplesPerPixel) {
    throw std::invalid_argument(
        fmt::format("A picture needs 1 to {} samples for each pixel.", kMaxSamplesPerPixel));
  }
}

Rendering render(const Scene& scene, const StructureUnderTest& structure, const RenderSettings& settings,
                 const RenderProgress& progress, const std::atomic<bool>* stop) {
  check_picture(settings);
  const PathTracer tracer(scene, structure, settings);
  Rendering rendering;
  const std::size_t top = settings.strip.top(settings.height), rows = settings.strip.rows(settings.height);
  rendering.image = empty_layers(settings.width, rows, structure.has_counters());
  rendering.image.top = static_cast<std::int64_t>(top);
  rendering.image.display = PixelWindow{0, 0, settings.width, settings.height};
  const Tiling tiles(settings.width, rows);
  Tally tally(rendering, tiles.count(), progress);
  std::optional<tbb::global_control> thread_limit;
  if (settings.threads > 0) {
    thread_limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
  }
  const auto start = std::chrono::steady_clock::now();
  tbb::parallel_for(std::size_t{0}, tiles.count(), [&](std::size_t index) {
    if (stop != nullptr && stop->load()) return;
    const Tile tile = tiles[index];
    std::uint64_t rays = 0, not_finite = 0;
    for (std::size_t y = tile.y0; y < tile.y1; ++y) {
      for (std::size_t x = tile.x0; x < tile.x1; ++x) {
        PixelSums sums;
        for (std::size_t i = 0; i < settings.samples_per_pixel; ++i) sums.add(tracer.trace(x, top + y, i));
        sums.store(rendering.image, y * settings.width + x);
        rays += sums.rays();
        not_finite += sums.not_finite();
      }
    }
    tally.add_tile(rays, not_finite);
  });
  rendering.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  rendering.is_complete = tally.is_complete();
  return rendering;
}

std::size_t rendering_bytes(const RenderSettings& settings) {
  return settings.width * settings.strip.rows(settings.height) * layer_bytes_per_pixel();
}

}  // namespace stbvh::harness
