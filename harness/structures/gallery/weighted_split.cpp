#include "harness/structures/gallery/weighted_split.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stbvh::harness::gallery {
namespace {

/// Which bin a reference falls into by its centroid along an axis.
class Bins {
 public:
  Bins(const ReferenceSet& set, int axis) : axis_(axis), lower_(set.centroids4.lower[axis]) {
    const float extent = set.centroids4.upper[axis] - lower_;
    const float scale = 0.99999f * static_cast<float>(kObjectBins) / extent;
    scale_ = extent > 0.0f && std::isfinite(scale) ? scale : 0.0f;
  }

  bool splits() const { return scale_ > 0.0f; }
  std::size_t of(const Reference& reference) const {
    return static_cast<std::size_t>((reference.bounds().centroid4()[axis_] - lower_) * scale_);
  }

 private:
  int axis_;
  float lower_, scale_;
};

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
  for (int axis = 0; axis < 3; ++axis) {
    const Bins bins(set, axis);
    if (!bins.splits()) continue;
    std::array<Side, kObjectBins> sides;
    for (const Reference& reference : set.references) {
      const auto segments = static_cast<double>(segments_of(context, reference, set.range));
      sides[bins.of(reference)].add({reference.bounds(), segments});
    }
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
    const Bins bins(set, split.axis);
    const auto middle =
        std::partition(set.references.begin(), set.references.end(),
                       [&](const Reference& reference) { return bins.of(reference) < split.position; });
    left = static_cast<std::size_t>(middle - set.references.begin());
  }
  return set.split_at(left);
}

}  // namespace stbvh::harness::gallery
