/// From the numbers of a picture to the colours that are shown: one structure or both, what they differ in,
/// what their rays met.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "harness/images/image.h"
#include "harness/preview/shown_picture.h"

namespace stbvh::harness {

enum class ViewMode { kA, kB, kSplit, kDifference };
enum class HeatMap { kNone, kNodes, kTriangles };

/// "a", "b", "split", "difference"; "none", "nodes", "triangles".
inline constexpr std::array<std::string_view, 4> kViewModeNames{"a", "b", "split", "difference"};
inline constexpr std::array<std::string_view, 3> kHeatMapNames{"none", "nodes", "triangles"};

struct ViewOptions {
  ViewMode mode = ViewMode::kSplit;
  double split = 0.5;  ///< share of the width that A has
  double gain = 10;    ///< of the difference
  HeatMap heat = HeatMap::kNone;
  double heat_largest = 32;  ///< what the lightest colour stands for

  bool operator==(const ViewOptions&) const = default;
};

/// Colours by table: what a display shows of radiance, within one step of srgb_byte(tone_mapped(radiance)).
class ViewComposer {
 public:
  ViewComposer();

  /// `picture` as `options` say. Where there is one structure only, it is shown alone, and differs in
  /// nothing; heat maps of a structure that does not count are grey. A difference is |A - B| times gain,
  /// linear; black: none.
  Image compose(ShownPicture& picture, const ViewOptions& options) const;

 private:
  using Rgb = std::array<std::uint8_t, 3>;
  Rgb color(const ShownPixel& pixel, std::size_t slot, bool has_counters, const ViewOptions& options) const;
  Rgb difference(const ShownPixel& pixel, const ViewOptions& options) const;

  std::vector<std::uint8_t> display_;  ///< by the upper half of a float's bits
  std::array<Rgb, 256> heat_;
};

}  // namespace stbvh::harness
