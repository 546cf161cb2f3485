#include "builder/temporal_split.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "builder/mbsah.h"
#include "builder/motion_bounds.h"

namespace stbvh {

namespace {

constexpr std::size_t kSample = 64;
constexpr std::size_t kChunk = 4096;
constexpr std::size_t kFarSet =
    64;  ///< smaller sets are not looked into far: it takes long, and larger ones were

/// Consecutive references mostly are of one mesh: its samples of the range are made once.
class ReferenceMaker {
 public:
  ReferenceMaker(const BuildContext& context, const ClosedTimeRange& range)
      : context_(context), range_(range) {}

  /// False where the reference's mesh is not alive in the range.
  bool make(const Reference& reference, LinearBounds& bounds) {
    const BuildMesh& mesh = context_.meshes[reference.mesh];
    if (mesh.is_static()) {
      bounds = reference.bounds();
      return true;
    }
    if (!samples_ || mesh_ != reference.mesh) {
      samples_.emplace(mesh, range_);
      mesh_ = reference.mesh;
    }
    if (samples_->empty()) return false;
    const Meshlet& meshlet = context_.meshlets[reference.mesh].meshlets()[reference.meshlet];
    bounds = motion_bounds(mesh, *samples_, meshlet.used_vertices());
    return true;
  }

 private:
  const BuildContext& context_;
  ClosedTimeRange range_;
  std::optional<MotionSamples> samples_;
  std::uint32_t mesh_ = 0;
};

/// The mesh of the finest grid, among the references of the sample; of several the one that comes first.
const BuildMesh* finest_mesh(const BuildContext& context, const ReferenceSet& set, std::size_t stride) {
  const BuildMesh* finest = nullptr;
  float most_segments = 0.0f;  // per unit of time
  for (std::size_t i = 0; i < set.size(); i += stride) {
    const BuildMesh& mesh = context.meshes[set.references[i].mesh];
    const float segments = mesh.segments_per_time(set.range);
    if (segments < most_segments || (segments == most_segments && &mesh >= finest)) continue;
    finest = &mesh;
    most_segments = segments;
  }
  return most_segments > 0.0f ? finest : nullptr;
}

}  // namespace

namespace {

/// Judges a reference's splits in time.
class SplitJudge {
 public:
  SplitJudge(const BuildContext& context, const ReferenceSet& set,
             const std::array<ClosedTimeRange, 2>& halves)
      : context_(context),
        range_(set.range),
        halves_(halves),
        makers_{ReferenceMaker(context, halves[0]), ReferenceMaker(context, halves[1])} {}

  bool wants_halves(const Reference& reference) {
    SplitCosts costs = whole(reference);
    for (std::size_t half = 0; half < 2; ++half) add(reference, makers_[half], halves_[half], costs);
    return costs.is_worth_it(context_.price);
  }

  /// Whether halves of halves are worth it, or halves of these, and so on.
  bool wants_parts(const Reference& reference) const {
    const BuildMesh& mesh = context_.meshes[reference.mesh];
    if (mesh.view().steps.size() <= kLongMotion) return false;
    std::vector<ClosedTimeRange> parts(halves_.begin(), halves_.end());
    for (;;) {
      std::vector<ClosedTimeRange> finer;
      for (const ClosedTimeRange& part : parts) {
        const std::optional<float> boundary = mesh.central_boundary(part);
        if (boundary) {
          for (const ClosedTimeRange& half : halves_at(part, *boundary)) finer.push_back(half);
        } else {
          finer.push_back(part);
        }
      }
      if (finer.size() == parts.size()) return false;
      parts = std::move(finer);
      SplitCosts costs = whole(reference);
      costs.more_leaves = parts.size() - 1;
      for (const ClosedTimeRange& part : parts) {
        ReferenceMaker maker(context_, part);
        add(reference, maker, part, costs);
      }
      if (costs.is_worth_it(context_.price)) return true;
    }
  }

 private:
  SplitCosts whole(const Reference& reference) const {
    const float area = expected_area(reference.bounds(), range_);
    return {area, context_.price.of_leaf(area, context_.meshes[reference.mesh].steps_in(range_))};
  }
  void add(const Reference& reference, ReferenceMaker& maker, const ClosedTimeRange& part,
           SplitCosts& costs) const {
    LinearBounds bounds;
    if (!maker.make(reference, bounds)) return;
    costs.add_part(context_.price, expected_area(bounds, part),
                   context_.meshes[reference.mesh].steps_in(part));
  }

  const BuildContext& context_;
  ClosedTimeRange range_;
  std::array<ClosedTimeRange, 2> halves_;
  std::array<ReferenceMaker, 2> makers_;
};

}  // namespace

std::optional<TemporalSplit> find_temporal_split(const BuildContext& context, const ReferenceSet& set) {
  const std::size_t stride = (set.size() + kSample - 1) / kSample;
  const BuildMesh* mesh = finest_mesh(context, set, stride);
  if (mesh == nullptr) return std::nullopt;
  const std::optional<float> boundary = mesh->central_boundary(set.range);
  if (!boundary) return std::nullopt;

  TemporalSplit split;
  split.halves = halves_at(set.range, *boundary);
  SplitJudge judge(context, set, split.halves);
  const bool looks_further = set.size() >= kFarSet;
  std::size_t wanted = 0, count = 0;
  for (std::size_t i = 0; i < set.size(); i += stride, ++count) {
    const Reference& reference = set.references[i];
    wanted += judge.wants_halves(reference) || (looks_further && judge.wants_parts(reference));
  }
  split.wanted_share = static_cast<float>(wanted) / static_cast<float>(count);
  return split;
}

ReferenceSet remake_references(const BuildContext& context, const ReferenceSet& set,
                               const ClosedTimeRange& range, std::span<Reference> storage) {
  const std::size_t chunks = (set.size() + kChunk - 1) / kChunk;
  std::vector<std::size_t> counts(chunks);
  const auto remake_chunk = [&](std::size_t chunk) {
    ReferenceMaker maker(context, range);
    const std::size_t begin = chunk * kChunk;
    std::size_t out = begin;
    for (std::size_t i = begin; i < std::min(begin + kChunk, set.size()); ++i) {
      LinearBounds bounds;
      const Reference& reference = set.references[i];
      if (maker.make(reference, bounds))
        storage[out++] = make_reference(bounds, reference.mesh, reference.meshlet);
    }
    counts[chunk] = out - begin;
  };
  if (chunks == 1) {
    remake_chunk(0);
  } else {
    tbb::parallel_for(std::size_t{0}, chunks, remake_chunk);
  }
  std::size_t total = 0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    std::memmove(static_cast<void*>(storage.data() + total), storage.data() + chunk * kChunk,
                 counts[chunk] * sizeof(Reference));
    total += counts[chunk];
  }
  ReferenceSet half;
  half.references = storage.first(total);
  half.range = range;
  half.update_bounds();
  return half;
}

}  // namespace stbvh
