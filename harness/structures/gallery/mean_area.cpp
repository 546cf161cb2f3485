#include "harness/structures/gallery/mean_area.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/binning.h"
#include "builder/object_split.h"

namespace stbvh::harness::gallery {
namespace {

constexpr std::size_t kParallelReferences = 32768;

float sum_of_areas(std::span<const Box4> boxes) {
  float sum = 0.0f;
  for (const Box4& box : boxes) sum += half_area(max(box.upper - box.lower, F32x4(0.0f)));
  return sum;
}

/// Boxes and counts; merging is exact, so the order in which threads merge does not matter.
struct Bins {
  std::vector<BoxesAtTimes> boxes;  ///< by axis, then by bin
  std::vector<std::uint32_t> counts;

  explicit Bins(std::size_t times) : boxes(3 * kObjectBins, BoxesAtTimes(times)), counts(3 * kObjectBins) {}
  void extend(const Bins& other) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      boxes[i].extend(other.boxes[i]);
      counts[i] += other.counts[i];
    }
  }
};

template <typename BoxesOf>
Bins bin_references(const ReferenceSet& set, const Binning& binning, std::size_t times,
                    const BoxesOf& boxes_of) {
  using Range = tbb::blocked_range<std::size_t>;
  const auto add = [&](const Range& part, Bins bins) {
    for (std::size_t i = part.begin(); i != part.end(); ++i) {
      const Reference& reference = set.references[i];
      std::array<std::uint32_t, 4> place;
      binning.bins(reference.bounds(), place);
      const BoxesAtTimes boxes = boxes_of(reference);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t bin = axis * kObjectBins + place[axis];
        bins.boxes[bin].extend(boxes);
        ++bins.counts[bin];
      }
    }
    return bins;
  };
  if (set.size() < kParallelReferences) return add(Range(0, set.size()), Bins(times));
  return tbb::parallel_reduce(Range(0, set.size(), kParallelReferences / 4), Bins(times), add,
                              [](Bins a, const Bins& b) {
                                a.extend(b);
                                return a;
                              });
}

/// The best place to cut a row of boxes in two, into `best` if it is cheaper than that.
void cut_row(int axis, std::span<const BoxesAtTimes> boxes, std::span<const std::uint32_t> counts,
             MeanAreaSplit& best) {
  std::vector<BoxesAtTimes> rights(boxes.begin(), boxes.end());  // each with all that follow
  std::vector<std::uint32_t> right_counts(counts.begin(), counts.end());
  for (std::size_t i = boxes.size() - 1; i > 0; --i) {
    rights[i - 1].extend(rights[i]);
    right_counts[i - 1] += right_counts[i];
  }
  BoxesAtTimes left(boxes[0].span().size());
  std::uint32_t count = 0;
  for (std::size_t i = 1; i < boxes.size(); ++i) {
    left.extend(boxes[i - 1]);
    count += counts[i - 1];
    if (count == 0 || right_counts[i] == 0) continue;
    const float cost = left.mean_area() * static_cast<float>(count) +
                       rights[i].mean_area() * static_cast<float>(right_counts[i]);
    if (cost < best.split.cost) best = {{cost, axis, i}, mean_overlap(left, rights[i])};
  }
}

}  // namespace

float BoxesAtTimes::mean_area() const {
  return sum_of_areas(span()) / static_cast<float>(count_);
}

float mean_overlap(const BoxesAtTimes& a, const BoxesAtTimes& b) {
  BoxesAtTimes common = a;
  for (std::size_t i = 0; i < common.span().size(); ++i) {
    Box4& box = common.span()[i];
    const Box4& other = b.span()[i];
    box = {max(box.lower, other.lower), min(box.upper, other.upper)};
    if (inverted_axes(box) != 0) box = Box4::empty();
  }
  return common.mean_area();
}

CompareTimes::CompareTimes(const ReferenceSet& set, std::span<const Piece> pieces) : range_(set.range) {
  std::size_t segments = 0;
  for (const Reference& reference : set.references)
    segments = std::max<std::size_t>(segments, pieces[reference.meshlet].sequence.grid.segments);
  count_ = std::min(segments + 1, kMostTimes);
}

BoxesAtTimes CompareTimes::interpolated(const BoxSequence& sequence) const {
  BoxesAtTimes boxes(count_);
  const std::span<Box4> out = boxes.span();
  const SequenceGrid& grid = sequence.grid;
  if (grid.segments == 0) {
    std::ranges::fill(out, sequence.boxes[0]);
    return boxes;
  }
  if (grid.segments + 1 == count_ && grid.begin == range_.begin && grid.end == range_.last) {
    std::ranges::copy(sequence.boxes, out.begin());
    return boxes;
  }
  const float last = static_cast<float>(grid.segments);
  for (std::size_t i = 0; i < count_; ++i) {
    const float time =
        range_.begin + range_.length() * static_cast<float>(i) / static_cast<float>(count_ - 1);
    const float u = std::clamp((time - grid.begin) / (grid.end - grid.begin) * last, 0.0f, last);
    const std::size_t segment = std::min(static_cast<std::size_t>(u), std::size_t{grid.segments} - 1);
    const F32x4 of_end(u - static_cast<float>(segment));
    const Box4& a = sequence.boxes[segment];
    const Box4& b = sequence.boxes[segment + 1];
    out[i] = {a.lower + of_end * (b.lower - a.lower), a.upper + of_end * (b.upper - a.upper)};
  }
  return boxes;
}

BoxesAtTimes CompareTimes::boxes_of(const BoxSequence& sequence) const {
  BoxesAtTimes boxes = interpolated(sequence);
  for (Box4& box : boxes.span()) {
    if (inverted_axes(box) != 0) box = Box4::empty();
  }
  return boxes;
}

MeanAreaBuilder::~MeanAreaBuilder() {
  context().memory.give_back(counted_bytes_.load());
}

void MeanAreaBuilder::count(std::size_t bytes) const {
  context().memory.take(bytes);
  counted_bytes_ += bytes;
}

ReferenceSet MeanAreaBuilder::make_references(std::span<Reference> storage) {
  ReferenceSet set = TopDown::make_references(storage);
  const MeshletSequences sequences(context());
  count(storage.size() * sizeof(Piece));
  pieces_.resize(storage.size());
  used_pieces_ = static_cast<std::uint32_t>(set.size());
  std::atomic<std::size_t> bytes{0};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, set.size(), 1024), [&](const auto& part) {
    for (std::size_t i = part.begin(); i != part.end(); ++i) {
      Reference& reference = set.references[i];
      const Meshlet& whole = meshlet(reference);
      pieces_[i] = {whole, reference.mesh, sequences.of(reference.mesh, whole)};
      bytes += pieces_[i].sequence.bytes();
      reference.meshlet = static_cast<std::uint32_t>(i);
    }
  });
  count(bytes.load());
  return set;
}

std::uint32_t MeanAreaBuilder::add_piece(const Piece& piece) const {
  count(piece.sequence.bytes());
  const std::uint32_t number = used_pieces_++;
  pieces_[number] = piece;
  return number;
}

void MeanAreaBuilder::enter_leaf(const ReferenceSet& set, BinaryLeaf& leaf) {
  const Piece& only = piece(set.references[0]);
  leaf.range = set.range;
  leaf.mesh = only.mesh;
  leaf.meshlet = &only;
}

std::optional<Split> MeanAreaBuilder::choose(const ReferenceSet& set) const {
  if (set.size() == 1) return std::nullopt;
  return find_split(set).split;
}

std::pair<ReferenceSet, ReferenceSet> MeanAreaBuilder::split_in_space(ReferenceSet& set,
                                                                      const ObjectSplit& split) const {
  return set.split_at(partition_references(set, split));
}

MeanAreaSplit MeanAreaBuilder::find_split(const ReferenceSet& set) const {
  const CompareTimes times(set, pieces_);
  const auto boxes_of = [&](const Reference& reference) { return times.boxes_of(piece(reference).sequence); };
  MeanAreaSplit best;
  if (set.size() <= kSweepLimit) {
    const std::vector<std::uint32_t> ones(set.size(), 1);
    for (int axis = 0; axis < 3; ++axis) {
      const SweepOrder order = sorted_order(set.references, axis);
      std::vector<BoxesAtTimes> row;
      for (std::size_t i = 0; i < set.size(); ++i) row.push_back(boxes_of(set.references[order[i]]));
      cut_row(axis, row, ones, best);
    }
    return best;
  }
  const Binning binning(set);
  const Bins bins = bin_references(set, binning, times.count(), boxes_of);
  for (int axis = 0; axis < 3; ++axis) {
    if (!binning.splits(axis)) continue;
    const std::size_t first = static_cast<std::size_t>(axis) * kObjectBins;
    cut_row(axis, std::span(bins.boxes).subspan(first, kObjectBins),
            std::span(bins.counts).subspan(first, kObjectBins), best);
  }
  return best;
}

}  // namespace stbvh::harness::gallery
