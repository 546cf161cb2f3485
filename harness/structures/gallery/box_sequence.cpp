/// `box-sequence`: a box at each step in every node, and the segment looked up at each node, as Grünschloß,
/// Stich, Nawaz and Keller 2011 ("MSBVH: An Efficient Acceleration Data Structure for Ray Traced Motion
/// Blur") have it, without their spatial splits (those are `msbvh`). The paper's text was not to be had; the
/// trees of appleseed and Psychopath, which hold such sequences, are what this follows.
///
/// Stored: for a grid of n equidistant segments n + 1 boxes of each child, by step (box_sequence_node.h);
/// for what stands still one box. Leaves hold all steps, as everywhere in the gallery.
/// Built: object splits alone, by the kernels' linear bounds over the whole shutter; collapsed to nodes of
/// eight, without a price for memory.
/// Traversed: each node finds the segment of the ray's time on its own grid and interpolates two boxes of
/// each child.
///
/// Where it departs: children of unlike step counts. Interpolating a box between steps of one grid is safe
/// only where each step of a child is a step of the node's grid, or corners of the motion are cut. The node's
/// grid is the least common multiple of the counts of its children, if that is not finer than kFinestMultiple
/// or the finest of them; the boxes of coarser ones are interpolated at its steps. A child that does not
/// fit, as its time range is another one or the multiple too fine, is held by one box for all times; so
/// are meshes whose steps have times of their own. Children that gain most by their motion choose first.
#include "harness/structures/gallery/box_sequence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "builder/sample_array.h"
#include "harness/structures/gallery/box_sequence_node.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/object_splits.h"
#include "harness/structures/gallery/wide_nodes.h"

namespace stbvh::harness::gallery {
namespace {

constexpr std::uint32_t kFinestMultiple = 128;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLeast = std::numeric_limits<float>::min();

SequenceGrid grid_of(const BuildMesh& mesh) {
  const TimeGrid& grid = mesh.grid();
  if (grid.is_static() || grid.is_uneven()) return {};
  return {grid.begin, grid.end, static_cast<std::uint32_t>(mesh.segments())};
}

bool same_times(const SequenceGrid& a, const SequenceGrid& b) {
  return a.begin == b.begin && a.end == b.end;
}

/// Whether each step of `coarse` is one of `fine`.
bool nests(const SequenceGrid& coarse, const SequenceGrid& fine) {
  return coarse.segments == 0 || (same_times(coarse, fine) && fine.segments % coarse.segments == 0);
}

float area(const Box4& box) {
  return half_area(max(box.upper - box.lower, F32x4(0.0f)));
}

/// By how much the sequence is smaller than its one box, in the mean.
float gain_of_motion(const BoxSequence& sequence) {
  float sum = 0.0f;
  for (const Box4& box : sequence.boxes) sum += area(box);
  return area(sequence.whole()) - sum / static_cast<float>(sequence.boxes.size());
}

/// Of a node with these children.
SequenceGrid common_grid(std::span<const BoxSequence* const> children) {
  struct Moving {
    SequenceGrid grid;
    float gain;
  };
  std::array<Moving, kWidth> moving;
  std::size_t count = 0;
  for (const BoxSequence* child : children) {
    if (child->grid.segments > 0) moving[count++] = {child->grid, gain_of_motion(*child)};
  }
  const std::span<Moving> used(moving.data(), count);
  std::ranges::stable_sort(used, std::ranges::greater(), &Moving::gain);
  SequenceGrid common;
  for (const auto& [grid, gain] : used) {
    if (common.segments == 0) common = grid;
    if (!same_times(common, grid)) continue;
    const std::uint32_t multiple = std::lcm(common.segments, grid.segments);
    if (multiple <= std::max({kFinestMultiple, common.segments, grid.segments})) common.segments = multiple;
  }
  return common;
}

/// Between two boxes, padded for what it rounds: at most 3 roundings of either corner, and one of the sum.
Box4 between(const Box4& a, const Box4& b, float fraction) {
  const F32x4 of_a(1.0f - fraction), of_b(fraction);
  const auto pad = [](F32x4 x, F32x4 y) { return F32x4(0x1p-21f) * (abs(x) + abs(y)) + F32x4(4 * kLeast); };
  return {of_a * a.lower + of_b * b.lower - pad(a.lower, b.lower),
          of_a * a.upper + of_b * b.upper + pad(a.upper, b.upper)};
}

/// The box of `sequence` at a step of a node's grid.
Box4 box_at(const BoxSequence& sequence, const SequenceGrid& grid, std::uint32_t step) {
  const std::uint32_t every = grid.segments / sequence.grid.segments;
  const Box4& box = sequence.boxes[step / every];
  if (step % every == 0) return box;
  return between(box, sequence.boxes[step / every + 1],
                 static_cast<float>(step % every) / static_cast<float>(every));
}

std::vector<Box4> boxes_on(const BoxSequence& sequence, const SequenceGrid& grid) {
  if (sequence.grid.segments == 0 || !nests(sequence.grid, grid))
    return {grid.segments + 1, sequence.whole()};
  std::vector<Box4> boxes;
  boxes.reserve(grid.segments + 1);
  for (std::uint32_t step = 0; step <= grid.segments; ++step) boxes.push_back(box_at(sequence, grid, step));
  return boxes;
}

/// Whether the boxes hold nothing at `step` and in the segments on both sides of it.
bool holds_nothing_around(std::span<const Box4> boxes, std::size_t step) {
  unsigned axes = inverted_axes(boxes[step]);
  if (axes != 0 && step > 0) axes &= inverted_axes(boxes[step - 1]);
  if (axes != 0 && step + 1 < boxes.size()) axes &= inverted_axes(boxes[step + 1]);
  return axes != 0;
}

/// A node computes (1 - f) a + f b of two padded planes: 1 - f, two products and the sum round by at most 3 *
/// 2^-24 of |(1 - f) a| + |f b|, and what is denormal may be flushed to zero.
void store_padded(const Box4& box, std::size_t slot, StepBoxes& step) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto pad = [](float x) { return 0x1p-21f * std::fabs(x) + 4 * kLeast; };
    const float lower = box.lower[axis], upper = box.upper[axis];
    step.planes[kLowerX + axis][slot] = lower - pad(lower);
    step.planes[kUpperX + axis][slot] = upper + pad(upper);
  }
}

/// For WideNodes.
class BoxSequences {
 public:
  using Bounds = BoxSequence;
  using Children = std::span<const BoxSequence* const>;

  explicit BoxSequences(const SequenceOfLeaf& of_leaf) : of_leaf_(of_leaf) {}

  Bounds of_leaf(const BinaryLeaf& leaf) const { return of_leaf_(leaf); }

  Bounds joined(Children children) const {
    BoxSequence all{common_grid(children), {}};
    for (const BoxSequence* child : children) {
      const std::vector<Box4> boxes = boxes_on(*child, all.grid);
      if (all.boxes.empty()) all.boxes.assign(boxes.size(), Box4::empty());
      for (std::size_t step = 0; step < boxes.size(); ++step) {
        if (!holds_nothing_around(boxes, step)) all.boxes[step].extend(boxes[step]);
      }
    }
    // Where no child holds anything, any box will do, but infinity cannot be interpolated.
    for (std::size_t step = 0; step < all.boxes.size(); ++step) {
      Box4& box = all.boxes[step];
      if (!(box.lower[0] < kInfinity)) box = boxes_on(*children[0], all.grid)[step];
    }
    return all;
  }

  std::size_t bytes(Children children) const {
    return sizeof(BoxSequenceNode) + (common_grid(children).segments + 1) * sizeof(StepBoxes);
  }

  void write(Children children, std::span<const Link> links, std::byte* out) const {
    const SequenceGrid grid = common_grid(children);
    auto& node = *new (out) BoxSequenceNode{};
    node.time_begin = grid.begin;
    node.segments_per_time = static_cast<float>(grid.segments) / (grid.end - grid.begin);
    node.segments = grid.segments;
    auto* const steps = reinterpret_cast<StepBoxes*>(out + sizeof node);
    for (std::uint32_t step = 0; step <= grid.segments; ++step) {
      for (std::size_t plane = 0; plane < kPlanes; ++plane)
        std::ranges::fill(steps[step].planes[plane], plane < kUpperX ? kEmptyPlane : -kEmptyPlane);
    }
    for (std::size_t i = 0; i < children.size(); ++i) {
      node.children[i] = links[i];
      const std::vector<Box4> boxes = boxes_on(*children[i], grid);
      for (std::size_t step = 0; step < boxes.size(); ++step) store_padded(boxes[step], i, steps[step]);
    }
  }

 private:
  const SequenceOfLeaf& of_leaf_;
};

std::vector<OutlinedChild> children_at(const GalleryView& view, Link link, float time) {
  const auto& node = *reinterpret_cast<const BoxSequenceNode*>(view.data + unit_of(link) * kUnitBytes);
  const StepBoxes* begin = steps_of(node);
  const StepBoxes* end = begin;
  float fraction = 0.0f;
  if (node.segments > 0) {
    const SegmentTime at = segment_at(node, time);
    begin += at.segment;
    end = begin + 1;
    fraction = at.fraction;
  }
  std::vector<OutlinedChild> children;
  for (std::size_t i = 0; i < kWidth && begin->planes[kLowerX][i] < kEmptyPlane; ++i) {
    const auto face = [&](Plane plane) {
      return (1.0f - fraction) * begin->planes[plane][i] + fraction * end->planes[plane][i];
    };
    const Box3f box{{face(kLowerX), face(kLowerY), face(kLowerZ)},
                    {face(kUpperX), face(kUpperY), face(kUpperZ)}};
    const bool is_empty = box.lower.x > box.upper.x || box.lower.y > box.upper.y || box.lower.z > box.upper.z;
    if (!is_empty) children.push_back({node.children[i], corners_of(box)});
  }
  return children;
}

class WithoutPrice final : public ObjectSplits {
 public:
  using ObjectSplits::ObjectSplits;

 private:
  BytePrice price(const ReferenceSet&) const override { return {}; }
};

}  // namespace

Box4 BoxSequence::whole() const {
  Box4 all = Box4::empty();
  for (const Box4& box : boxes) all.extend(box);
  return all;
}

MeshletSequences::MeshletSequences(const BuildContext& context) : context_(context) {
  for (const BuildMesh& mesh : context.meshes)
    samples_.emplace_back(mesh, ClosedTimeRange{mesh.grid().begin, mesh.grid().end});
}

// The pad of sample_boxes() is one for the whole sequence. Of its 16 * 2^-24 of a segment's motion, for each
// segment, a mesh's own evaluation of the fraction takes 4, and a node's, which is as many operations on a
// grid of the same length, 4 more: in segments of the mesh, however much finer the node's are.
BoxSequence MeshletSequences::of(std::uint32_t mesh, const Meshlet& meshlet) const {
  const MotionSamples& samples = samples_[mesh];
  SampleArray<BoundsSample> at_steps(samples.samples.size());
  const std::span<BoundsSample> used(at_steps.data(), samples.samples.size());
  sample_boxes(context_.meshes[mesh], samples, meshlet.used_vertices(), used);
  BoxSequence sequence{grid_of(context_.meshes[mesh]), {}};
  sequence.boxes.reserve(used.size());
  for (const BoundsSample& sample : used) sequence.boxes.push_back(sample.box);
  if (sequence.grid.segments == 0) sequence.boxes = {sequence.whole()};
  return sequence;
}

// The part of a box inside a limit has the face min(face, limit), which is concave in a segment that crosses
// the limit: interpolated between its values at the steps it would be too small. So a face is moved only
// where it is not inside the limit at both neighbouring steps, either. Then no segment is shrunk that crosses
// the limit at its unclipped face: of a segment's two ends both are moved, and the face is the limit; or one,
// and the other lies beyond the limit, so that the face between is the limit at least; or none.
void clip(std::span<Box4> boxes, const Box4& limits) {
  const auto is_beyond = [&](const Box4& box) {
    return std::array{_mm_cmpge_ps(limits.lower.v, box.lower.v), _mm_cmpge_ps(box.upper.v, limits.upper.v)};
  };
  const auto choose = [](__m128 mask, F32x4 a, F32x4 b) {
    return F32x4(_mm_or_ps(_mm_and_ps(mask, a.v), _mm_andnot_ps(mask, b.v)));
  };
  auto here = is_beyond(boxes[0]);
  auto before = here;
  for (std::size_t step = 0; step < boxes.size(); ++step) {
    const auto after = step + 1 < boxes.size() ? is_beyond(boxes[step + 1]) : here;
    Box4& box = boxes[step];
    box.lower = choose(_mm_and_ps(here[0], _mm_and_ps(before[0], after[0])), limits.lower, box.lower);
    box.upper = choose(_mm_and_ps(here[1], _mm_and_ps(before[1], after[1])), limits.upper, box.upper);
    before = here;
    here = after;
  }
}

WrittenTree write_box_sequences(const BuildContext& context, const BinaryNode& root,
                                const SequenceOfLeaf& of_leaf) {
  return write_wide_nodes(context, BoxSequences(of_leaf), root, method_kernels().box_sequence, children_at,
                          nullptr, 0);
}

StructurePtr build_box_sequence(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  GalleryTree::Method method;
  method.make_builder = [](BuildContext& context) { return std::make_unique<WithoutPrice>(context); };
  method.write = [](BuildContext& context, BinaryNode& root) {
    const MeshletSequences sequences(context);
    return write_box_sequences(
        context, root, [&](const BinaryLeaf& leaf) { return sequences.of(leaf.mesh, *leaf.meshlet); });
  };
  return std::make_unique<GalleryTree>(scene, method, threads, progress);
}

}  // namespace stbvh::harness::gallery
