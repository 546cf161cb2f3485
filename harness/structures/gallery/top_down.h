/// The builder that the methods of the gallery share: our own, taken apart. By itself it builds the very tree
/// of kernels/builder; a method overrides what it does otherwise.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <cstddef>
#include <variant>

#include "builder/binary_node.h"
#include "builder/build_context.h"
#include "builder/collapse.h"
#include "builder/object_split.h"
#include "builder/reference_set.h"

namespace stbvh::harness::gallery {

using TimeHalves = std::array<ClosedTimeRange, 2>;

/// How a set of references is split.
using Split = std::variant<TimeHalves, ObjectSplit>;

class TopDown {
 public:
  /// `context` has its meshes, and their meshlets; both must outlive the tree.
  explicit TopDown(BuildContext& context);
  virtual ~TopDown() = default;
  TopDown(const TopDown&) = delete;
  TopDown& operator=(const TopDown&) = delete;

  /// Null: there is no valid triangle that is ever alive.
  BinaryNode* build();

  /// Times and bounds of the whole, once it is built.
  const ReferenceSet& all() const { return all_; }

 protected:
  /// A finished subtree, with what the node above it needs to know.
  struct Subtree {
    BinaryNode* node = nullptr;
    CollapseCosts costs;
  };

  // What a method may do otherwise -------------------------------------------------------------------------

  /// How many references there are at first, and which.
  virtual std::size_t reference_count() const;
  virtual ReferenceSet make_references(std::span<Reference> storage);
  /// Changes the bounds of a set that was just made, for all times or for one half of them.
  virtual void fit(ReferenceSet&) const {}
  /// What memory has to bring, for the collapse.
  virtual BytePrice price(const ReferenceSet& all) const;
  /// Whether what stands still is a side of the root.
  virtual bool parts_still_from_moving() const { return true; }
  virtual bool is_leaf(const ReferenceSet& set) const { return set.size() == 1; }
  /// How `set` is split; of one reference it can be in time only, none: it is a leaf.
  virtual std::optional<Split> choose(const ReferenceSet& set) const;
  /// The two sides of an object split.
  virtual std::pair<ReferenceSet, ReferenceSet> split_in_space(ReferenceSet& set,
                                                               const ObjectSplit& split) const;
  /// Fills meshlet, mesh and range.
  virtual void enter_leaf(const ReferenceSet& set, BinaryLeaf& leaf);
  virtual LinearBounds inner_bounds(const ReferenceSet& set, const BinaryNode& left,
                                    const BinaryNode& right) const;
  virtual ClosedTimeRange inner_range(const ReferenceSet& set, const BinaryNode& left,
                                      const BinaryNode& right) const;
  /// Says which binary nodes become the children of one node of eight, where that is not as cheap as
  /// possible.
  virtual void collapse(BinaryNode&) const {}

  BuildContext& context() const { return context_; }
  const Meshlet& meshlet(const Reference& reference) const {
    return context_.meshlets[reference.mesh].meshlets()[reference.meshlet];
  }
  /// Memory of the calling thread that lives as long as the tree.
  Arena& arena() { return arenas_.local(); }

 private:
  Subtree build_root(ReferenceSet& set);
  Subtree build_node(ReferenceSet set, std::size_t depth);
  Subtree build_halves(const ReferenceSet& set, const TimeHalves& halves, std::size_t depth);
  Subtree build_sides(const ReferenceSet& set, const std::pair<ReferenceSet, ReferenceSet>& sides,
                      std::size_t depth);
  Subtree make_leaf(const ReferenceSet& set);
  Subtree make_inner(const ReferenceSet& set, const Subtree& left, const Subtree& right);

  BuildContext& context_;
  tbb::enumerable_thread_specific<Arena> arenas_;
  ReferenceSet all_;
  double total_work_ = 0;
};

}  // namespace stbvh::harness::gallery
