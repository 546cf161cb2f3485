/// Builds the kd-tree over space and time of `kd4`.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "builder/build_context.h"
#include "harness/structures/gallery/kd4_nodes.h"
#include "layout/linear_bounds.h"

namespace stbvh::harness::gallery {

/// A part of the space and of the shutter.
struct KdCell {
  Box4 box = Box4::empty();
  ClosedTimeRange range{1.0f, 0.0f};
};

class KdBuilder {
 public:
  /// `context` has its meshes, and their meshlets.
  explicit KdBuilder(BuildContext& context);
  ~KdBuilder();
  KdBuilder(const KdBuilder&) = delete;
  KdBuilder& operator=(const KdBuilder&) = delete;

  /// False: nothing is ever alive.
  bool build();

  /// Once it is built: what the root holds, and how much write() writes.
  const KdCell& all() const { return all_; }
  std::size_t node_count() const { return node_count_; }
  std::size_t link_count() const { return link_count_; }
  /// Meshlets are numbered through all meshes; `leaves` has a link to each.
  void write(std::span<const Link> leaves, KdNode* nodes, Link* links) const;

 private:
  struct Reference;
  class References;
  struct Task;
  struct Split;
  struct Subtree;
  class BoxesOver;
  class Planes;
  using Sides = std::array<std::unique_ptr<Task>, 2>;

  void make_step_boxes();
  std::unique_ptr<Task> whole_task();
  std::unique_ptr<Subtree> build_subtree(std::unique_ptr<Task> task);
  void build_node(std::unique_ptr<Task> task, std::size_t node, Subtree& out) const;
  void count(const Subtree& subtree);

  Split find_split(const Task& task) const;
  void try_time(const Task& task, Split& best) const;
  std::unique_ptr<Task> new_side(const Task& whole, const KdCell& cell, std::size_t most) const;
  Sides sides_in_time(const Task& task, float boundary) const;
  Sides sides_in_space(const Task& task, std::size_t axis, float plane) const;
  /// Splits `task`, which is gone then; none where that is not worth it, or takes too many references.
  std::optional<Sides> split(std::unique_ptr<Task>& task, Split& split) const;

  BuildContext& context_;
  KdCell all_;
  std::vector<std::size_t> first_number_;  ///< of each mesh, in the meshlets of all
  /// Of each meshlet of each mesh at each step.
  std::vector<std::unique_ptr<TemporaryArray<Box4>>> step_boxes_;
  std::unique_ptr<Subtree> root_;
  std::unique_ptr<CountedMemory> counted_;  ///< what `root_` takes
  std::size_t node_count_ = 0;
  std::size_t link_count_ = 0;
};

}  // namespace stbvh::harness::gallery
