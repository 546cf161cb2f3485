/// `msbvh`: Grünschloß's spatial splits on our builder (Grünschloß, Stich, Nawaz and Keller 2011, "MSBVH: An
/// Efficient Acceleration Data Structure for Ray Traced Motion Blur"). Its text was not to be had.
/// What is known of it: spatial splits, and bounds that are interpolated between steps. All else is inferred,
/// after the SBVH (Stich, Friedrich and Dietrich 2009).
///
/// Stored, traversed: as `box-sequence`.
/// Built: as `box-sequence-tsah`, but where the sides of the best object split overlap by more than
/// kLeastOverlap of the root's area, planes are tried, too: 32 bins in each axis over the space that the set
/// ever takes. A plane stands still in space for all times. A reference on both sides of it at any time goes
/// to both, each with its boxes clipped, or to one of them whole where that is cheaper (Stich's unsplitting).
/// All areas are means over time.
///
/// A reference is a meshlet, of which each side keeps the triangles that ever reach it, so its boxes shrink
/// in all axes. Triangles themselves are not clipped: polygons clipped at steps do not hold, interpolated,
/// what lies between. A leaf is written for each reference. There are at most kMostReferences times as many
/// as without spatial splits. What a set has left of that is shared out to its sides by their references, so
/// that the tree does not depend on the order in which threads build it.
///
/// Why no hit is lost: at each time the pieces of a triangle's bounds hold together all that the bounds hold,
/// as each piece has the part of the bounds on its side of each plane at least (clip()). The point that the
/// triangle test reports lies within the bounds of its triangle, as far as rays are padded for
/// (docs/accuracy.md), and so in that of one piece.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "builder/sample_array.h"
#include "builder/tightest_bounds.h"
#include "harness/structures/gallery/mean_area.h"

namespace stbvh::harness::gallery {
namespace {

constexpr float kLeastOverlap = 1e-5f;  // Stich's alpha
constexpr double kMostReferences = 1.5;
constexpr std::size_t kBins = 32;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Values of ObjectSplit::axis beside those of object splits. A spatial split keeps the bits of its plane in
/// `position`.
constexpr int kFirstSpatialAxis = 3;
constexpr int kStillFromMoving = 6;

/// All points with `lower` <= the coordinate on `axis` <= `upper`.
Box4 slab(int axis, float lower, float upper) {
  const auto on_axis = [&](float x, float others) {
    return F32x4(axis == 0 ? x : others, axis == 1 ? x : others, axis == 2 ? x : others);
  };
  return {on_axis(lower, -kInfinity), on_axis(upper, kInfinity)};
}

LinearBounds linear_bounds(const BoxSequence& sequence, const ClosedTimeRange& range) {
  const auto& [grid, boxes] = sequence;
  if (grid.segments == 0 || grid.begin != range.begin || grid.end != range.last)
    return {sequence.whole(), sequence.whole()};
  SampleArray<BoundsSample> samples(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    samples[i] = {static_cast<float>(i) / static_cast<float>(grid.segments), boxes[i]};
  return tightest_at_centre({samples.data(), boxes.size()});
}

/// The triangles of `meshlet` for which `keep` says so, with their vertices.
template <typename Keep>
Meshlet with_triangles(const Meshlet& meshlet, const Keep& keep) {
  Meshlet kept{};
  const auto slot_of = [&](std::uint32_t vertex) {
    const auto end = std::begin(kept.vertices) + kept.vertex_count;
    const auto found = std::find(std::begin(kept.vertices), end, vertex);
    if (found == end) kept.vertices[kept.vertex_count++] = vertex;
    return static_cast<std::uint8_t>(found - std::begin(kept.vertices));
  };
  for (std::size_t i = 0; i < meshlet.triangle_count; ++i) {
    if (!keep(i)) continue;
    kept.prims[kept.triangle_count] = meshlet.prims[i];
    for (std::size_t corner = 0; corner < 3; ++corner)
      kept.corners[corner][kept.triangle_count] = slot_of(meshlet.vertices[meshlet.corners[corner][i]]);
    ++kept.triangle_count;
  }
  return kept;
}

/// Of a plane.
struct Side {
  BoxesAtTimes boxes;
  std::vector<Reference> references;
};

class Msbvh final : public MeanAreaBuilder {
 public:
  explicit Msbvh(BuildContext& context) : MeanAreaBuilder(context), sequences_(context) {}

 private:
  auto is_still() const {
    return [this](const Reference& reference) { return context().meshes[reference.mesh].is_static(); };
  }

  std::size_t reference_count() const override {
    return static_cast<std::size_t>(static_cast<double>(TopDown::reference_count()) * kMostReferences);
  }

  ReferenceSet make_references(std::span<Reference> storage) override {
    const ReferenceSet all = MeanAreaBuilder::make_references(storage);
    storage_ = storage.data();
    whole_size_ = all.size();
    room_end_.resize(storage.size());
    if (all.size() == 0) return all;
    room_end_[0] = storage.size();
    const CompareTimes times(all, pieces());
    BoxesAtTimes boxes(times.count());
    for (const Reference& reference : all.references) boxes.extend(times.boxes_of(piece(reference).sequence));
    least_overlap_ = kLeastOverlap * boxes.mean_area();
    return all;
  }

  bool parts_still_from_moving() const override { return false; }  // choose() does

  std::optional<Split> choose(const ReferenceSet& set) const override {
    if (set.size() == 1) return std::nullopt;
    if (is_whole(set) && std::ranges::any_of(set.references, is_still()) &&
        !std::ranges::all_of(set.references, is_still()))
      return ObjectSplit{0.0f, kStillFromMoving, 0};
    const MeanAreaSplit object = find_split(set);
    if (room_of(set) == 0 || object.overlap <= least_overlap_) return object.split;
    const ObjectSplit spatial = find_spatial_split(set);
    return spatial.cost < object.split.cost ? spatial : object.split;
  }

  std::pair<ReferenceSet, ReferenceSet> split_in_space(ReferenceSet& set,
                                                       const ObjectSplit& split) const override {
    if (split.axis == kStillFromMoving) {
      const auto moving = std::partition(set.references.begin(), set.references.end(), is_still());
      return with_room(set, static_cast<std::size_t>(moving - set.references.begin()));
    }
    if (split.axis < kFirstSpatialAxis) return with_room(set, partition_references(set, split));
    return split_at_plane(set, split.axis - kFirstSpatialAxis,
                          std::bit_cast<float>(static_cast<std::uint32_t>(split.position)));
  }

  std::size_t place_of(const ReferenceSet& set) const {
    return static_cast<std::size_t>(set.references.data() - storage_);
  }
  bool is_whole(const ReferenceSet& set) const { return place_of(set) == 0 && set.size() == whole_size_; }
  /// How many references more `set` may become.
  std::size_t room_of(const ReferenceSet& set) const {
    const std::size_t place = place_of(set);
    return room_end_[place] - place - set.size();
  }

  /// Both sides of a set whose first references are the left one, with their shares of the room behind it.
  std::pair<ReferenceSet, ReferenceSet> with_room(const ReferenceSet& set, std::size_t left_count) const {
    const std::size_t place = place_of(set);
    const std::size_t right_place = place + left_count + room_of(set) * left_count / set.size();
    const std::span<Reference> right(storage_ + right_place, set.size() - left_count);
    std::move_backward(set.references.begin() + static_cast<std::ptrdiff_t>(left_count), set.references.end(),
                       right.end());
    room_end_[right_place] = room_end_[place];
    room_end_[place] = right_place;
    const auto side = [&](std::span<Reference> references) {
      ReferenceSet made;
      made.references = references;
      made.range = set.range;
      made.update_bounds();
      return made;
    };
    return {side(set.references.first(left_count)), side(right)};
  }

  /// Boxes of the parts in each bin, and how many references begin and end there.
  struct SpatialBins {
    std::vector<BoxesAtTimes> boxes;
    std::array<std::size_t, kBins> begun{}, ended{};
    explicit SpatialBins(std::size_t times) : boxes(kBins, BoxesAtTimes(times)) {}
  };

  ObjectSplit find_spatial_split(const ReferenceSet& set) const {
    const CompareTimes times(set, pieces());
    Box4 space = Box4::empty();
    for (const Reference& reference : set.references) space.extend(piece(reference).sequence.whole());
    ObjectSplit best;
    for (int axis = 0; axis < 3; ++axis) {
      const float lower = space.lower[axis], size = space.upper[axis] - lower;
      const float scale = static_cast<float>(kBins) / size;
      if (!(size > 0.0f) || !std::isfinite(scale)) continue;
      const auto plane = [&](std::size_t i) { return lower + size * static_cast<float>(i) / float{kBins}; };
      const auto bin = [&](float x) {
        return std::min(static_cast<std::size_t>(std::max(0.0f, (x - lower) * scale)), kBins - 1);
      };
      SpatialBins bins(times.count());
      for (const Reference& reference : set.references) {
        const BoxSequence& sequence = piece(reference).sequence;
        const Box4 whole = sequence.whole();
        const std::size_t first = bin(whole.lower[axis]), last = bin(whole.upper[axis]);
        ++bins.begun[first];
        ++bins.ended[last];
        const BoxesAtTimes boxes = times.boxes_of(sequence);
        for (std::size_t i = first; i <= last; ++i)
          add_part(boxes, slab(axis, plane(i), plane(i + 1)), bins.boxes[i]);
      }
      cut_bins(set.size(), axis, plane, bins, best);
    }
    return best;
  }

  /// Extends `all` by what of `boxes` lies inside `limits`, where that is something.
  static void add_part(BoxesAtTimes boxes, const Box4& limits, BoxesAtTimes& all) {
    clip(boxes.span(), limits);
    for (std::size_t i = 0; i < boxes.span().size(); ++i) {
      if (overlap(boxes.span()[i], limits)) all.span()[i].extend(boxes.span()[i]);
    }
  }

  template <typename PlaneAt>
  static void cut_bins(std::size_t size, int axis, const PlaneAt& plane, const SpatialBins& bins,
                       ObjectSplit& best) {
    std::vector<BoxesAtTimes> rights = bins.boxes;
    for (std::size_t i = kBins - 1; i > 0; --i) rights[i - 1].extend(rights[i]);
    BoxesAtTimes left(rights[0].span().size());
    std::size_t left_count = 0, right_count = size;
    for (std::size_t i = 1; i < kBins; ++i) {
      left.extend(bins.boxes[i - 1]);
      left_count += bins.begun[i - 1];
      right_count -= bins.ended[i - 1];
      if (left_count == size || right_count == size) continue;  // would go on for ever
      const float cost = cost_of(left, left_count, rights[i], right_count);
      if (cost < best.cost) best = {cost, axis + kFirstSpatialAxis, std::bit_cast<std::uint32_t>(plane(i))};
    }
  }

  static float cost_of(const BoxesAtTimes& left, std::size_t left_count, const BoxesAtTimes& right,
                       std::size_t right_count) {
    return left.mean_area() * static_cast<float>(left_count) +
           right.mean_area() * static_cast<float>(right_count);
  }

  std::pair<ReferenceSet, ReferenceSet> split_at_plane(const ReferenceSet& set, int axis, float plane) const {
    const CompareTimes times(set, pieces());
    const std::array<Box4, 2> limits{slab(axis, -kInfinity, plane), slab(axis, plane, kInfinity)};
    std::array<Side, 2> sides{Side{BoxesAtTimes(times.count()), {}}, Side{BoxesAtTimes(times.count()), {}}};
    std::vector<Reference> cut;
    for (const Reference& reference : set.references) {
      const BoxSequence& sequence = piece(reference).sequence;
      const Box4 whole = sequence.whole();
      const bool is_cut = whole.lower[axis] < plane && whole.upper[axis] > plane;
      if (is_cut) cut.push_back(reference);
      for (std::size_t i = 0; i < 2; ++i) {
        if (is_cut) {
          add_part(times.boxes_of(sequence), limits[i], sides[i].boxes);
        } else if ((i == 0) == (whole.upper[axis] <= plane)) {
          sides[i].boxes.extend(times.boxes_of(sequence));
          sides[i].references.push_back(reference);
        }
      }
    }
    share_out(set, times, cut, limits, sides);
    ReferenceSet both = set;
    both.references = {set.references.data(), sides[0].references.size() + sides[1].references.size()};
    std::ranges::copy(sides[0].references, both.references.begin());
    std::ranges::copy_backward(sides[1].references, both.references.end());
    const std::size_t left_count = sides[0].references.size();
    // The bins have seen references on both sides, but may have rounded otherwise.
    const bool is_one_sided = left_count == 0 || left_count == both.size();
    return with_room(both, is_one_sided ? both.size() / 2 : left_count);
  }

  /// Puts references that the plane cuts on both sides, or on that one where it is cheaper.
  void share_out(const ReferenceSet& set, const CompareTimes& times, std::span<const Reference> cut,
                 const std::array<Box4, 2>& limits, std::array<Side, 2>& sides) const {
    std::size_t room = room_of(set);
    std::array<std::size_t, 2> counts{sides[0].references.size() + cut.size(),
                                      sides[1].references.size() + cut.size()};
    for (const Reference& reference : cut) {
      const BoxesAtTimes boxes = times.boxes_of(piece(reference).sequence);
      std::array<BoxesAtTimes, 2> grown{sides[0].boxes, sides[1].boxes};
      for (BoxesAtTimes& side : grown) side.extend(boxes);
      const float in_left = cost_of(grown[0], counts[0], sides[1].boxes, counts[1] - 1);
      const float in_right = cost_of(sides[0].boxes, counts[0] - 1, grown[1], counts[1]);
      const float in_both = cost_of(sides[0].boxes, counts[0], sides[1].boxes, counts[1]);
      if (room > 0 && in_both < std::min(in_left, in_right)) {
        const std::array<Piece, 2> parts{part_of(piece(reference), limits[0]),
                                         part_of(piece(reference), limits[1])};
        if (parts[0].triangle_count > 0 && parts[1].triangle_count > 0) {
          changed_piece(reference) = parts[0];
          sides[0].references.push_back(reference_to(parts[0], reference.meshlet, set.range));
          sides[1].references.push_back(reference_to(parts[1], add_piece(parts[1]), set.range));
          --room;
          continue;
        }
      }
      const std::size_t one = in_left <= in_right ? 0 : 1;
      sides[one].boxes = grown[one];
      sides[one].references.push_back(reference);
      --counts[1 - one];
    }
  }

  static Reference reference_to(const Piece& piece, std::uint32_t number, const ClosedTimeRange& range) {
    return make_reference(linear_bounds(piece.sequence, range), piece.mesh, number);
  }

  /// The triangles of `whole` that ever reach into `limits`, clipped.
  Piece part_of(const Piece& whole, const Box4& limits) const {
    const auto reaches = [&](std::size_t triangle) {
      const Meshlet alone = with_triangles(whole, [&](std::size_t i) { return i == triangle; });
      return overlap(sequences_.of(whole.mesh, alone).whole(), limits);
    };
    Piece part{with_triangles(whole, reaches), whole.mesh, {}, limits_of(whole, limits)};
    if (part.triangle_count == 0) return part;
    part.sequence = sequences_.of(part.mesh, part);
    clip(part.sequence.boxes, part.limits);
    return part;
  }

  static Box4 limits_of(const Piece& whole, const Box4& limits) {
    return {max(whole.limits.lower, limits.lower), min(whole.limits.upper, limits.upper)};
  }

  MeshletSequences sequences_;
  Reference* storage_ = nullptr;
  std::size_t whole_size_ = 0;
  float least_overlap_ = 0.0f;
  /// By the place where a set begins: where the room behind it ends.
  mutable std::vector<std::size_t> room_end_;
};

}  // namespace

StructurePtr build_msbvh(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_of_pieces<Msbvh>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
