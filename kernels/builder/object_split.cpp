#include "builder/object_split.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>

#include "builder/binning.h"

namespace stbvh {

namespace {

constexpr std::size_t kParallelReferences = 32768;

/// Bounds and counts; merging is exact, so the order in which threads merge does not matter.
struct Bins {
  std::array<std::array<LinearBounds, kObjectBins>, 3> bounds;
  std::array<std::array<std::uint32_t, kObjectBins>, 3> counts{};

  Bins() {
    for (auto& axis : bounds) axis.fill(LinearBounds::empty());
  }
  void add(std::span<const Reference> references, const Binning& binning) {
    std::array<std::uint32_t, 4> bin;
    for (const Reference& reference : references) {
      const LinearBounds b = reference.bounds();
      binning.bins(b, bin);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds[axis][bin[axis]].extend(b);
        ++counts[axis][bin[axis]];
      }
    }
  }
  void merge(const Bins& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < kObjectBins; ++i) {
        bounds[axis][i].extend(other.bounds[axis][i]);
        counts[axis][i] += other.counts[axis][i];
      }
    }
  }
};

Bins bin_references(std::span<const Reference> references, const Binning& binning) {
  if (references.size() < kParallelReferences) {
    Bins bins;
    bins.add(references, binning);
    return bins;
  }
  using Range = tbb::blocked_range<std::size_t>;
  return tbb::parallel_reduce(
      Range(0, references.size(), kParallelReferences / 4), Bins(),
      [&](const Range& range, Bins bins) {
        bins.add(references.subspan(range.begin(), range.size()), binning);
        return bins;
      },
      [](Bins a, const Bins& b) {
        a.merge(b);
        return a;
      });
}

float side_cost(const LinearBounds& bounds, std::size_t count) {
  return count == 0 ? 0.0f : bounds.centre_area() * static_cast<float>(count);
}

ObjectSplit find_binned_split(const ReferenceSet& set) {
  const Binning binning(set);
  const Bins bins = bin_references(set.references, binning);
  ObjectSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!binning.splits(axis)) continue;
    const auto& bounds = bins.bounds[static_cast<std::size_t>(axis)];
    const auto& counts = bins.counts[static_cast<std::size_t>(axis)];
    std::array<float, kObjectBins> right_costs;
    std::array<std::size_t, kObjectBins> right_counts;
    LinearBounds side = LinearBounds::empty();
    std::size_t count = 0;
    for (std::size_t i = kObjectBins - 1; i > 0; --i) {
      side.extend(bounds[i]);
      count += counts[i];
      right_counts[i] = count;
      right_costs[i] = side_cost(side, count);
    }
    side = LinearBounds::empty();
    count = 0;
    for (std::size_t i = 1; i < kObjectBins; ++i) {
      side.extend(bounds[i - 1]);
      count += counts[i - 1];
      if (count == 0 || right_counts[i] == 0) continue;
      const float cost = side_cost(side, count) + right_costs[i];
      if (cost < best.cost) best = {cost, axis, i};
    }
  }
  return best;
}

ObjectSplit find_swept_split(const ReferenceSet& set) {
  const std::size_t n = set.size();
  std::array<LinearBounds, kSweepLimit> bounds;
  for (std::size_t i = 0; i < n; ++i) bounds[i] = set.references[i].bounds();
  ObjectSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    const SweepOrder order = sorted_order(set.references, axis);
    std::array<float, kSweepLimit> right_costs;
    LinearBounds side = LinearBounds::empty();
    for (std::size_t i = n - 1; i > 0; --i) {
      side.extend(bounds[order[i]]);
      right_costs[i] = side_cost(side, n - i);
    }
    side = LinearBounds::empty();
    for (std::size_t i = 1; i < n; ++i) {
      side.extend(bounds[order[i - 1]]);
      const float cost = side_cost(side, i) + right_costs[i];
      if (cost < best.cost) best = {cost, axis, i};
    }
  }
  return best;
}

}  // namespace

SweepOrder sorted_order(std::span<const Reference> references, int axis) {
  std::array<float, kSweepLimit> centroids;
  for (std::size_t i = 0; i < references.size(); ++i) centroids[i] = references[i].bounds().centroid4()[axis];
  SweepOrder order{};
  for (std::size_t i = 0; i < references.size(); ++i) {  // insertion sort: there are few
    std::size_t j = i;
    for (; j > 0 && centroids[order[j - 1]] > centroids[i]; --j) order[j] = order[j - 1];
    order[j] = static_cast<std::uint8_t>(i);
  }
  return order;
}

ObjectSplit find_object_split(const ReferenceSet& set) {
  return set.size() <= kSweepLimit ? find_swept_split(set) : find_binned_split(set);
}

std::size_t partition_references(ReferenceSet& set, const ObjectSplit& split) {
  if (!(split.cost < std::numeric_limits<float>::infinity())) return set.size() / 2;
  if (set.size() <= kSweepLimit) {
    const SweepOrder order = sorted_order(set.references, split.axis);
    std::array<Reference, kSweepLimit> sorted;
    for (std::size_t i = 0; i < set.size(); ++i) sorted[i] = set.references[order[i]];
    std::copy_n(sorted.begin(), set.size(), set.references.begin());
    return split.position;
  }
  const Binning binning(set);
  const auto middle =
      std::partition(set.references.begin(), set.references.end(), [&](const Reference& reference) {
        std::array<std::uint32_t, 4> bin;
        binning.bins(reference.bounds(), bin);
        return bin[static_cast<std::size_t>(split.axis)] < split.position;
      });
  return static_cast<std::size_t>(middle - set.references.begin());
}

std::pair<ReferenceSet, ReferenceSet> apply_object_split(ReferenceSet& set, const ObjectSplit& split) {
  return set.split_at(partition_references(set, split));
}

}  // namespace stbvh
