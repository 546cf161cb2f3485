#include "harness/structures/gallery/weighted_split.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/binning.h"

namespace stbvh::harness::gallery {
namespace {

struct Side {
  LinearBounds bounds = LinearBounds::empty();
  double segments = 0;

  void add(const Side& other) {
    bounds.extend(other.bounds);
    segments += other.segments;
  }
  float cost() const {
    return segments > 0 ? static_cast<float>(static_cast<double>(bounds.centre_area()) * segments) : 0.0f;
  }
};

}  // namespace

std::size_t segments_of(const BuildContext& context, const Reference& reference,
                        const ClosedTimeRange& range) {
  const BuildMesh& mesh = context.meshes[reference.mesh];
  const std::size_t triangles = context.meshlets[reference.mesh].meshlets()[reference.meshlet].triangle_count;
  if (mesh.is_static()) return triangles;
  const std::size_t steps = mesh.steps_in(range);
  return steps == 0 ? 0 : triangles * (steps - 1);
}

std::size_t segments_of(const BuildContext& context, const ReferenceSet& set) {
  std::size_t segments = 0;
  for (const Reference& reference : set.references) segments += segments_of(context, reference, set.range);
  return segments;
}

ObjectSplit find_weighted_split(const BuildContext& context, const ReferenceSet& set) {
  ObjectSplit best;
  const Binning binning(set);
  std::array<std::array<Side, kObjectBins>, 3> bins;
  for (const Reference& reference : set.references) {
    const Side one{reference.bounds(), static_cast<double>(segments_of(context, reference, set.range))};
    std::array<std::uint32_t, 4> place;
    binning.bins(one.bounds, place);
    for (std::size_t axis = 0; axis < 3; ++axis) bins[axis][place[axis]].add(one);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!binning.splits(axis)) continue;
    const std::array<Side, kObjectBins>& sides = bins[static_cast<std::size_t>(axis)];
    std::array<Side, kObjectBins> right;
    right[kObjectBins - 1] = sides[kObjectBins - 1];
    for (std::size_t i = kObjectBins - 1; i > 0; --i) {
      right[i - 1] = right[i];
      right[i - 1].add(sides[i - 1]);
    }
    Side left;
    for (std::size_t i = 1; i < kObjectBins; ++i) {
      left.add(sides[i - 1]);
      if (left.segments == 0 || right[i].segments == 0) continue;
      const float cost = left.cost() + right[i].cost();
      if (cost < best.cost) best = {cost, axis, i};
    }
  }
  return best;
}

std::pair<ReferenceSet, ReferenceSet> apply_weighted_split(ReferenceSet& set, const ObjectSplit& split) {
  std::size_t left = set.size() / 2;
  if (std::isfinite(split.cost)) {
    const Binning binning(set);
    const auto middle =
        std::partition(set.references.begin(), set.references.end(), [&](const Reference& reference) {
          std::array<std::uint32_t, 4> place;
          binning.bins(reference.bounds(), place);
          return place[static_cast<std::size_t>(split.axis)] < split.position;
        });
    left = static_cast<std::size_t>(middle - set.references.begin());
  }
  return set.split_at(left);
}

}  // namespace stbvh::harness::gallery
