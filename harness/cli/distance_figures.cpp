#include "harness/cli/distance_figures.h"

namespace stbvh::harness {
namespace {

Percentiles percentiles(const std::vector<double>& values) {
  return {percentile(values, 0.5), percentile(values, 0.99), percentile(values, 1)};
}

}  // namespace

DistanceFigures distance_figures(const DistanceErrors& errors) {
  return {.relative = percentiles(errors.relative),
          .ulps = percentiles(errors.ulps),
          .off_plane = percentiles(errors.off_plane),
          .grazing = errors.off_plane.size()};
}

}  // namespace stbvh::harness
