/// Splits by the mean over time of the surface area of boxes, which `box-sequence-tsah` and `msbvh` build
/// with.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "builder/reference_set.h"
#include "harness/structures/gallery/box_sequence.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/top_down.h"

namespace stbvh::harness::gallery {

/// A meshlet, or what planes have left of it: what a reference's number stands for here.
struct Piece : Meshlet {
  std::uint32_t mesh = 0;
  BoxSequence sequence;
  Box4 limits{F32x4(-std::numeric_limits<float>::infinity()),
              F32x4(std::numeric_limits<float>::infinity())};  ///< of the planes
};

/// Areas are compared at as many times at most.
inline constexpr std::size_t kMostTimes = 17;

/// Boxes at the times at which areas are compared.
class BoxesAtTimes {
 public:
  explicit BoxesAtTimes(std::size_t count) : count_(count) {
    for (Box4& box : span()) box = Box4::empty();
  }
  std::span<Box4> span() { return {boxes_.data(), count_}; }
  std::span<const Box4> span() const { return {boxes_.data(), count_}; }

  void extend(const BoxesAtTimes& other) {
    for (std::size_t i = 0; i < count_; ++i) boxes_[i].extend(other.boxes_[i]);
  }
  float mean_area() const;

 private:
  std::size_t count_;
  std::array<Box4, kMostTimes> boxes_;
};

/// How large what both have in common is, in the mean.
float mean_overlap(const BoxesAtTimes& a, const BoxesAtTimes& b);

/// The times at which the areas of one set are compared: the steps of its finest piece, or as many as there
/// may be.
class CompareTimes {
 public:
  CompareTimes(const ReferenceSet& set, std::span<const Piece> pieces);

  std::size_t count() const { return count_; }
  /// Empty at times at which the sequence holds nothing.
  BoxesAtTimes boxes_of(const BoxSequence& sequence) const;

 private:
  BoxesAtTimes interpolated(const BoxSequence& sequence) const;

  ClosedTimeRange range_;
  std::size_t count_;
};

/// An object split, and what it makes of the boxes.
struct MeanAreaSplit {
  ObjectSplit split;
  float overlap = 0.0f;  ///< of its sides
};

/// Builds with pieces: `meshlet` of a reference is the number of its piece.
class MeanAreaBuilder : public TopDown {
 public:
  explicit MeanAreaBuilder(BuildContext& context) : TopDown(context) {}
  ~MeanAreaBuilder() override;

  static const BoxSequence& sequence_of(const BinaryLeaf& leaf) {
    return static_cast<const Piece*>(leaf.meshlet)->sequence;
  }

 protected:
  ReferenceSet make_references(std::span<Reference> storage) override;
  BytePrice price(const ReferenceSet&) const override { return {}; }
  std::optional<Split> choose(const ReferenceSet& set) const override;
  std::pair<ReferenceSet, ReferenceSet> split_in_space(ReferenceSet& set,
                                                       const ObjectSplit& split) const override;
  void enter_leaf(const ReferenceSet& set, BinaryLeaf& leaf) override;

  /// The cheapest: mean area times references, summed over both sides.
  MeanAreaSplit find_split(const ReferenceSet& set) const;

  const Piece& piece(const Reference& reference) const { return pieces_[reference.meshlet]; }
  Piece& changed_piece(const Reference& reference) const { return pieces_[reference.meshlet]; }
  std::span<const Piece> pieces() const { return pieces_; }
  /// A further piece. May be called by several threads at once.
  std::uint32_t add_piece(const Piece& piece) const;

 private:
  void count(std::size_t bytes) const;

  mutable std::vector<Piece> pieces_;
  mutable std::atomic<std::uint32_t> used_pieces_{0};
  mutable std::atomic<std::size_t> counted_bytes_{0};
};

/// What a builder has built, with the sequences of its pieces.
template <typename Builder>
StructurePtr build_of_pieces(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  GalleryTree::Method method;
  method.make_builder = [](BuildContext& context) { return std::make_unique<Builder>(context); };
  method.write = [](BuildContext& context, BinaryNode& root) {
    return write_box_sequences(context, root, MeanAreaBuilder::sequence_of);
  };
  return std::make_unique<GalleryTree>(scene, method, threads, progress);
}

}  // namespace stbvh::harness::gallery
