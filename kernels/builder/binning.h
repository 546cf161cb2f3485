/// The bins of object splits.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "builder/object_split.h"
#include "builder/reference_set.h"

namespace stbvh {

/// Maps centroids to bins, the same way for binning and for partitioning.
class Binning {
 public:
  explicit Binning(const ReferenceSet& set) : lower_(set.centroids4.lower) {
    const F32x4 extent = set.centroids4.upper - set.centroids4.lower;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float e = extent[static_cast<int>(axis)];
      // Just below the number of bins, so that the largest centroid falls into the last one.
      const float scale = e > 0.0f ? 0.99999f * static_cast<float>(kObjectBins) / e : 0.0f;
      scale_[axis] = std::isfinite(scale) ? scale : 0.0f;
    }
    scale4_ = _mm_set_ps(0.0f, scale_[2], scale_[1], scale_[0]);
  }
  bool splits(int axis) const { return scale_[static_cast<std::size_t>(axis)] > 0.0f; }

  void bins(const LinearBounds& bounds, std::array<std::uint32_t, 4>& out) const {
    const F32x4 position = (bounds.centroid4() - lower_) * scale4_;
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out.data()), _mm_cvttps_epi32(position.v));
  }

 private:
  F32x4 lower_;
  F32x4 scale4_;
  std::array<float, 3> scale_{};
};

}  // namespace stbvh
