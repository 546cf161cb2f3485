/// The top-down builder: from meshes to a binary tree of object and temporal splits.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <atomic>
#include <optional>
#include <vector>

#include "builder/binary_node.h"
#include "builder/build_context.h"
#include "builder/collapse.h"
#include "builder/leaf_survey.h"
#include "builder/reference_set.h"

namespace stbvh {

struct ObjectSplit;

/// The tree and the memory that its nodes live in.
class BinaryTree {
 public:
  /// Groups the triangles of all meshes.
  explicit BinaryTree(BuildContext& context);

  /// Splits until every set fits a leaf, for a structure of about `bytes` at most, or of what rays profit
  /// from where that is less; how to collapse the tree is worked out on the way up. Called again it builds
  /// another tree.
  void build(double bytes);

  /// What a structure would take that is not limited, about; known once build() has been called.
  double wanted_bytes() const { return wanted_bytes_; }

  BinaryNode* root() { return root_; }  ///< null: there is no valid triangle
  const BinaryNode* root() const { return root_; }
  ClosedTimeRange range() const { return range_; }
  /// Of a mesh at all times, known once build() has been called; empty where it is never alive.
  const Box4& mesh_bounds(std::size_t mesh) const { return mesh_bounds_[mesh]; }
  std::size_t temporal_splits() const { return temporal_splits_.load(); }

 private:
  /// A finished subtree, with what the node above it needs to know.
  struct Subtree {
    BinaryNode* node = nullptr;
    CollapseCosts costs;
  };

  void choose_price(const ReferenceSet& all, double bytes);
  /// Static meshes and moving ones go to different sides of the root: what stands still is mostly large, and
  /// would stretch the boxes of what moves.
  Subtree build_root(ReferenceSet& set);
  Subtree build_node(ReferenceSet set, std::size_t depth);
  Subtree build_children(const ClosedTimeRange& range, const ReferenceSet& left_set,
                         const ReferenceSet& right_set, std::size_t depth);
  Subtree make_leaf(const ReferenceSet& set);  ///< of one reference
  Subtree make_inner(const ClosedTimeRange& range, const Subtree& left, const Subtree& right);
  Subtree split_in_time(const ReferenceSet& set, const std::array<ClosedTimeRange, 2>& halves,
                        std::size_t depth);
  Subtree split_in_space(ReferenceSet& set, std::size_t depth, const ObjectSplit& split);

  BuildContext& context_;
  std::optional<LeafSurvey> survey_;
  std::optional<CountedMemory> survey_memory_;
  tbb::enumerable_thread_specific<Arena> arenas_;
  BinaryNode* root_ = nullptr;
  ClosedTimeRange range_{0.0f, 1.0f};
  std::vector<Box4> mesh_bounds_;
  double total_work_ = 0;
  double wanted_bytes_ = 0;
  std::atomic<std::size_t> temporal_splits_{0};
};

}  // namespace stbvh
