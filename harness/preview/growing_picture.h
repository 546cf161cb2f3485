/// A picture that grows sample by sample through one or two structures: coarse first, then finer, then less
/// and less noisy. With n samples of all pixels it is, to the last bit, what render() makes of n samples.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>

#include "harness/path_tracer/pixel_layers.h"
#include "harness/path_tracer/render.h"
#include "harness/preview/shown_picture.h"
#include "harness/preview/work_crew.h"

namespace stbvh::harness {

/// A structure and what it stands on.
struct BuiltStructure {
  std::shared_ptr<const Scene> scene;
  std::string asked_scene;  ///< built-in name or file, as it was asked for
  std::string name;         ///< of the structure
  std::unique_ptr<StructureUnderTest> structure;
};
using BuiltStructurePtr = std::shared_ptr<const BuiltStructure>;
using BuiltPair = std::array<BuiltStructurePtr, kSlots>;  ///< A, and B or null

/// What is found out while a picture grows.
struct PictureFigures {
  std::size_t samples = 0;                      ///< of each pixel, all done
  std::array<std::uint64_t, kSlots> rays{};     ///< of all kinds
  std::array<double, kSlots> thread_seconds{};  ///< of processor time that they took
  std::uint64_t compared = 0;                   ///< camera rays sent through both structures
  std::uint64_t mismatches = 0;  ///< of them that found another triangle in one than in the other
  /// Of them those where this structure passed by a triangle that the oracle says is hit for certain, and the
  /// other structure found.
  std::array<std::uint64_t, kSlots> leaks{};
  double seconds = 0;             ///< since it was begun
  double first_pass_seconds = 0;  ///< from there to something in every place

  double mrays_per_thread_second(std::size_t slot) const {
    return thread_seconds[slot] > 0 ? static_cast<double>(rays[slot]) / 1e6 / thread_seconds[slot] : 0;
  }
};

/// Elements that do not exist before they are constructed: memory that the coarsest pass does not need costs
/// it nothing.
template <typename T>
class UntouchedArray {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  /// Elements are lost where `size` is another one.
  void resize(std::size_t size) {
    if (size == size_) return;
    elements_ = {};
    size_ = 0;
    if (size == 0) return;
    elements_ = {std::allocator<T>().allocate(size), Free{size}};
    size_ = size;
  }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return elements_.get()[i]; }
  const T& operator[](std::size_t i) const { return elements_.get()[i]; }

 private:
  struct Free {
    std::size_t size = 0;
    void operator()(T* elements) const { std::allocator<T>().deallocate(elements, size); }
  };
  std::unique_ptr<T, Free> elements_;
  std::size_t size_ = 0;
};

class GrowingPicture {
 public:
  /// Coarse passes: one pixel in squares of 16, 8, 4, 2, 1.
  static constexpr std::size_t kCoarsePasses = 5;

  explicit GrowingPicture(WorkCrew& crew) : crew_(crew) {}

  /// Begins a new picture. Memory of the last one is used again. Throws std::invalid_argument for what cannot
  /// be shown, as PathTracer does.
  void begin(const BuiltPair& structures, const RenderSettings& settings);

  /// The next pass over all pixels; false, with the picture spoilt, where `stop` became true.
  bool add_pass(const std::atomic<bool>& stop);
  std::size_t passes() const { return passes_; }

  const std::shared_ptr<ShownPicture>& shown() const { return shown_; }
  PictureFigures figures() const;

  /// All layers of structure `slot` so far, each pixel with at least one sample. Between passes.
  Rendering rendering(std::size_t slot) const;

 private:
  struct TileTally;
  void add_to_tile(const Tile& tile, const std::atomic<bool>& stop);
  void trace_tile(const Tile& tile, std::size_t slot, const std::atomic<bool>& stop, TileTally& tally);
  void compare(std::size_t x, std::size_t y, std::size_t sample, TileTally& tally) const;
  void show_tile(const Tile& tile);
  template <typename Visit>
  void for_each_pixel(const Tile& tile, const Visit& visit) const;
  std::size_t step() const { return passes_ < kCoarsePasses ? Tiling::kSide >> passes_ : 1; }
  std::size_t sample() const { return passes_ < kCoarsePasses ? 0 : passes_ + 1 - kCoarsePasses; }

  WorkCrew& crew_;
  BuiltPair structures_;
  std::size_t slots_ = 0;
  RenderSettings settings_;
  std::array<std::optional<PathTracer>, kSlots> tracers_;
  std::array<UntouchedArray<PixelSums>, kSlots> sums_;  ///< of pixels not traced yet: nothing
  std::atomic<std::size_t> passes_{0};
  ShownPicturePool pool_;
  std::shared_ptr<ShownPicture> shown_;
  std::chrono::steady_clock::time_point start_;
  mutable std::mutex mutex_;
  PictureFigures figures_;
};

}  // namespace stbvh::harness
