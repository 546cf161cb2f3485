#include "harness/preview/growing_picture.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "harness/oracle/oracle.h"
#include "harness/path_tracer/path_tracer.h"

namespace stbvh::harness {
namespace {

ShownPixel shown_pixel(const PixelSums* a, const PixelSums* b) {
  ShownPixel pixel;
  std::size_t slot = 0;
  for (const PixelSums* sums : {a, b}) {
    if (sums != nullptr) {
      const Vec3f mean = to_float(sums->mean());
      pixel.radiance[slot] = {mean.x, mean.y, mean.z};
      pixel.nodes[slot] = static_cast<float>(sums->nodes());
      pixel.triangles[slot] = static_cast<float>(sums->triangle_tests());
    }
    ++slot;
  }
  return pixel;
}

/// Whether a structure that found `found` (or nothing) passed by `other`, a triangle that `ray` hits for
/// certain.
bool passes_by(const Scene& scene, const Ray& ray, const FirstHit& found, const FirstHit& other) {
  if (!other.is_hit) return false;
  const auto test = test_primitive(scene, ray, other.mesh, other.prim);
  if (!test || !test->is_certain) return false;
  if (!found.is_hit) return true;
  const auto own = test_primitive(scene, ray, found.mesh, found.prim);
  return own && own->t_lower > test->t_upper;
}

}  // namespace

/// Of one tile in one pass.
struct GrowingPicture::TileTally {
  std::array<std::uint64_t, kSlots> rays{}, leaks{};
  std::array<double, kSlots> seconds{};
  std::uint64_t compared = 0, mismatches = 0;
  std::array<std::array<FirstHit, Tiling::kSide * Tiling::kSide>, kSlots> first;

  static std::size_t place(const Tile& tile, std::size_t x, std::size_t y) {
    return (y - tile.y0) * Tiling::kSide + (x - tile.x0);
  }
};

void GrowingPicture::begin(const BuiltPair& structures, const RenderSettings& settings) {
  check_picture(settings);
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    tracers_[slot].reset();
    if (structures[slot])
      tracers_[slot].emplace(*structures[slot]->scene, *structures[slot]->structure, settings);
  }
  structures_ = structures;
  slots_ = structures[1] ? 2 : 1;
  settings_ = settings;
  passes_ = 0;
  for (std::size_t slot = 0; slot < slots_; ++slot) sums_[slot].resize(settings.width * settings.height);
  for (std::size_t slot = slots_; slot < kSlots; ++slot) sums_[slot].resize(0);
  shown_ = pool_.take(settings.width, settings.height);
  shown_->slots = slots_;
  shown_->settings = settings;
  for (std::size_t slot = 0; slot < kSlots; ++slot)
    shown_->has_counters[slot] = structures[slot] && structures[slot]->structure->has_counters();
  start_ = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  figures_ = {};
}

bool GrowingPicture::add_pass(const std::atomic<bool>& stop) {
  const Tiling tiles(settings_.width, settings_.height);
  crew_.run(tiles.count(), [&](std::size_t i) {
    if (!stop) add_to_tile(tiles[i], stop);
  });
  if (stop) return false;
  ++passes_;
  const std::lock_guard lock(mutex_);
  if (passes_ >= kCoarsePasses) figures_.samples = passes_ + 1 - kCoarsePasses;
  figures_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  if (passes_ == 1) figures_.first_pass_seconds = figures_.seconds;
  return true;
}

PictureFigures GrowingPicture::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

/// The pixels of `tile` that this pass adds a sample to.
template <typename Visit>
void GrowingPicture::for_each_pixel(const Tile& tile, const Visit& visit) const {
  const std::size_t side = step(), coarser = passes_ == 0 || passes_ >= kCoarsePasses ? 0 : 2 * side;
  for (std::size_t y = tile.y0; y < tile.y1; y += side) {
    for (std::size_t x = tile.x0; x < tile.x1; x += side) {
      if (coarser > 0 && (x - tile.x0) % coarser == 0 && (y - tile.y0) % coarser == 0) continue;
      visit(x, y);
    }
  }
}

void GrowingPicture::add_to_tile(const Tile& tile, const std::atomic<bool>& stop) {
  const auto tally = std::make_unique<TileTally>();
  // Each goes first in half of the tiles: the second one finds vertices and materials in the caches.
  const std::size_t first = slots_ == 2 ? (tile.x0 + tile.y0) / Tiling::kSide % 2 : 0;
  for (std::size_t i = 0; i < slots_; ++i) trace_tile(tile, (first + i) % slots_, stop, *tally);
  if (stop) return;
  if (slots_ == 2) {
    for_each_pixel(tile, [&](std::size_t x, std::size_t y) { compare(x, y, sample(), *tally); });
  }
  show_tile(tile);
  const std::lock_guard lock(mutex_);
  for (std::size_t slot = 0; slot < slots_; ++slot) {
    figures_.rays[slot] += tally->rays[slot];
    figures_.thread_seconds[slot] += tally->seconds[slot];
    figures_.leaks[slot] += tally->leaks[slot];
  }
  figures_.compared += tally->compared;
  figures_.mismatches += tally->mismatches;
}

void GrowingPicture::trace_tile(const Tile& tile, std::size_t slot, const std::atomic<bool>& stop,
                                TileTally& tally) {
  const double start = thread_seconds();
  for_each_pixel(tile, [&](std::size_t x, std::size_t y) {
    if (stop) return;
    PixelSums& sums = sums_[slot][y * settings_.width + x];
    if (sample() == 0) std::construct_at(&sums);
    const PathSample path = tracers_[slot]->trace(x, y, sample());
    sums.add(path);
    tally.rays[slot] += path.rays;
    tally.first[slot][TileTally::place(tile, x, y)] = path.first;
  });
  tally.seconds[slot] += thread_seconds() - start;
}

void GrowingPicture::compare(std::size_t x, std::size_t y, std::size_t sample, TileTally& tally) const {
  const std::size_t side = Tiling::kSide, place = y % side * side + x % side;
  const FirstHit &a = tally.first[0][place], &b = tally.first[1][place];
  ++tally.compared;
  if (a.mesh == b.mesh && a.prim == b.prim) return;
  ++tally.mismatches;
  const Ray ray = tracers_[0]->camera_ray(x, y, sample);
  const Scene& scene = *structures_[0]->scene;
  if (passes_by(scene, ray, a, b)) ++tally.leaks[0];
  if (passes_by(scene, ray, b, a)) ++tally.leaks[1];
}

void GrowingPicture::show_tile(const Tile& tile) {
  const auto sums = [&](std::size_t slot, std::size_t pixel) {
    return slot < slots_ ? &sums_[slot][pixel] : nullptr;
  };
  const std::lock_guard lock(shown_->lock_of(tile));
  for_each_pixel(tile, [&](std::size_t x, std::size_t y) {
    const std::size_t pixel = y * settings_.width + x;
    shown_->fill(tile, x, y, step(), shown_pixel(sums(0, pixel), sums(1, pixel)));
  });
  ++shown_->version;
}

Rendering GrowingPicture::rendering(std::size_t slot) const {
  Rendering result;
  result.image =
      empty_layers(settings_.width, settings_.height, structures_[slot]->structure->has_counters());
  for (std::size_t i = 0; i < sums_[slot].size(); ++i) {
    sums_[slot][i].store(result.image, i);
    result.rays += sums_[slot][i].rays();
    result.not_finite += sums_[slot][i].not_finite();
  }
  const PictureFigures all = figures();
  result.seconds = all.thread_seconds[slot] / static_cast<double>(crew_.threads());
  result.is_complete = true;
  return result;
}

}  // namespace stbvh::harness
