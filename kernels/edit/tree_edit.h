/// Leaves of some meshes rewritten where their vertices have moved, or taken out, and the nodes above them.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "builder/build_mesh.h"
#include "builder/build_progress.h"
#include "builder/motion_bounds.h"
#include "builder/tree_counts.h"
#include "edit/unit_space.h"
#include "layout/meshlet.h"
#include "layout/node_slots.h"
#include "simd/box4.h"

namespace stbvh {

/// What becomes of the leaves of one record of the mesh table.
struct RecordEdit {
  enum class Fate : std::uint8_t { kStays, kMoved, kRemoved };

  Fate fate = Fate::kStays;
  const BuildMesh* mesh = nullptr;  ///< as it is now, of those that moved
  Box4 before = Box4::empty();      ///< of its leaves as they are in the tree
};

struct NodeChildren;

/// Thrown where a node does not fit into the block.
struct BlockIsFull {};

class TreeEdit {
 public:
  /// `table` is that of the tree as it is; there is one edit for each of its records.
  TreeEdit(std::byte* data, UnitSpace& space, const MeshRecord* table, std::vector<RecordEdit> records,
           const BuildProgress& progress);

  struct Outcome {
    bool is_changed = false;
    bool is_gone = false;
    NodeSlot slot{};      ///< of what is left, where it is changed and not gone
    TreeCounts change{};  ///< of what the tree consists of
  };
  /// Of the tree at `root`. Throws BlockIsFull and BuildCancelled; the tree is of no use then.
  Outcome apply(Link root, const ClosedTimeRange& range);

  std::size_t leaves_moved() const { return leaves_moved_; }

  /// Boxes of the leaves of records that moved.
  const std::vector<Box4>& bounds() const { return bounds_; }
  /// Records that moved so that some leaf can no longer hold them: corners that shared a vertex have come
  /// apart. Those leaves are as they were.
  std::vector<std::uint32_t> torn_records() const;

 private:
  /// What one thread has met.
  struct Met {
    std::vector<Box4> bounds;  ///< of the leaves of each record that moved
    std::size_t leaves_moved = 0;
  };

  bool may_hold_edits(const LinearBounds& bounds) const;
  LinearBounds bounds_of_moved(const BuildMesh& mesh, std::uint32_t record, const ClosedTimeRange& range,
                               const Meshlet& meshlet) const;
  Outcome visit(Link link, const ClosedTimeRange& range, std::size_t level);
  Outcome visit_leaf(Link link, const ClosedTimeRange& range);
  Outcome visit_node(Link link, const ClosedTimeRange& range, std::size_t level);
  /// `children`: the bounds of those of `after`.
  Outcome rewritten(Link link, const NodeSlots& before, const NodeSlots& after, const NodeChildren& children,
                    TreeCounts change);
  void give_back(std::size_t unit, std::size_t units);

  std::byte* data_;
  UnitSpace& space_;
  const MeshRecord* table_;
  std::vector<RecordEdit> records_;
  const BuildProgress& progress_;
  std::vector<Box4> edited_;                           ///< boxes outside of which nothing changes
  ClosedTimeRange whole_{};                            ///< of the root
  std::vector<std::optional<MotionSamples>> samples_;  ///< of each record that moved, over whole_
  tbb::enumerable_thread_specific<Met> met_;
  std::vector<Box4> bounds_;
  std::size_t leaves_moved_ = 0;
  std::vector<std::uint8_t> torn_;
  std::mutex mutex_;  ///< of the space and torn_
};

/// Linear bounds of a node over `range`.
LinearBounds bounds_of(const NodeSlots& node);

/// Of all children of a node.
double expected_area(const NodeSlots& node);

}  // namespace stbvh
