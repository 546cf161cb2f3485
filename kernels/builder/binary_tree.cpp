#include "builder/binary_tree.h"

#include <tbb/task_group.h>

#include <algorithm>
#include <array>
#include <new>

#include "builder/make_references.h"
#include "builder/mbsah.h"
#include "builder/merged_bounds.h"
#include "builder/object_split.h"
#include "builder/temporal_split.h"

namespace stbvh {

namespace {

constexpr std::size_t kParallelSet = 1024;    ///< sets from this size on are built as tasks of their own
constexpr std::size_t kSplitDepthLimit = 56;  ///< below, sets are only halved
// Fewer than 2^32 references are in a set, as BinaryNode::subtree_leaves counts them: one is left 32 halvings
// below.
static_assert(kSplitDepthLimit + 32 <= kMaxLevels, "the traversal's stacks hold no deeper tree");
constexpr std::size_t kPollSet = 65536;  ///< sets from this size on ask the progress callback themselves

/// Where TBB has no memory for it the tasks run to their end.
void cancel(tbb::task_group& group) {
  try {
    group.cancel();
  } catch (const std::bad_alloc&) {
  }
}

/// Runs both on the task scheduler where `parallel`, else one after the other. Exceptions of either get out.
template <typename F, typename G>
void invoke_both(bool parallel, const F& f, const G& g) {
  if (!parallel) {
    f();
    g();
    return;
  }
  tbb::task_group group;
  group.run(g);
  try {
    f();
  } catch (...) {
    cancel(group);
    group.wait();  // a group that nobody waited for ends the process
    throw;
  }
  // Skipped where a task above has thrown: that one's exception gets out in the end.
  if (group.wait() == tbb::task_group_status::canceled) throw BuildCancelled();
}

}  // namespace

BinaryTree::BinaryTree(BuildContext& context)
    : context_(context), arenas_([&context] { return Arena(context.memory); }) {
  make_meshlets(context);
}

void BinaryTree::build(double bytes) {
  arenas_.clear();
  root_ = nullptr;
  temporal_splits_ = 0;
  mesh_bounds_.assign(context_.meshes.size(), Box4::empty());
  std::size_t meshlets = 0;
  for (const MeshletSet& set : context_.meshlets) meshlets += set.meshlets().size();
  if (meshlets == 0) return;
  TemporaryArray<Reference> storage(context_.memory, meshlets);
  ReferenceSet all = make_references(context_, storage.span());
  range_ = all.range;
  for (const Reference& reference : all.references)
    mesh_bounds_[reference.mesh].extend(reference.bounds().whole());
  if (all.size() == 0) return;
  choose_price(all, bytes);
  total_work_ =
      static_cast<double>(all.size()) * std::max(1e-30, static_cast<double>(range_.last) - range_.begin);
  context_.progress.restart();
  root_ = build_root(all).node;
}

void BinaryTree::choose_price(const ReferenceSet& all, double bytes) {
  if (!survey_) {
    survey_.emplace(context_, all);
    wanted_bytes_ = survey_->bytes_at(survey_->usual_price());
    survey_memory_.emplace(context_.memory, survey_->bytes());
  }
  context_.price = bytes < wanted_bytes_ ? survey_->price_for(bytes) : survey_->usual_price();
}

BinaryTree::Subtree BinaryTree::build_root(ReferenceSet& set) {
  const auto is_static = [&](const Reference& reference) {
    return context_.meshes[reference.mesh].is_static();
  };
  const auto moving = std::partition(set.references.begin(), set.references.end(), is_static);
  const auto count = static_cast<std::size_t>(moving - set.references.begin());
  if (count == 0 || count == set.size()) return build_node(set, 0);
  const auto [still, moves] = set.split_at(count);
  return build_children(set.range, still, moves, 1);
}

BinaryTree::Subtree BinaryTree::build_node(ReferenceSet set, std::size_t depth) {
  if (set.size() >= kPollSet) context_.progress.poll();
  context_.progress.check();
  const bool may_choose = depth < kSplitDepthLimit;
  if (may_choose) {
    const std::optional<TemporalSplit> temporal = find_temporal_split(context_, set);
    if (temporal && temporal->wanted_share >= kTemporalShare)
      return split_in_time(set, temporal->halves, depth);
  }
  if (set.size() == 1) return make_leaf(set);
  ObjectSplit object;
  if (may_choose) object = find_object_split(set);
  return split_in_space(set, depth, object);
}

BinaryTree::Subtree BinaryTree::split_in_time(const ReferenceSet& set,
                                              const std::array<ClosedTimeRange, 2>& halves,
                                              std::size_t depth) {
  temporal_splits_.fetch_add(1, std::memory_order_relaxed);
  Subtree subtrees[2];
  const auto build_half = [&](std::size_t half) {
    TemporaryArray<Reference> storage(context_.memory, set.size());
    const ReferenceSet remade = remake_references(context_, set, halves[half], storage.span());
    if (remade.size() > 0) subtrees[half] = build_node(remade, depth + 1);
  };
  // One half after the other where the set is small: its copy is given back before the other is made.
  invoke_both(
      set.size() >= kParallelSet, [&] { build_half(0); }, [&] { build_half(1); });
  const auto& [first, second] = subtrees;
  if (first.node == nullptr && second.node == nullptr) throw BuildCancelled();  // tasks were skipped
  if (first.node == nullptr || second.node == nullptr) return first.node != nullptr ? first : second;
  return make_inner(set.range, first, second);
}

BinaryTree::Subtree BinaryTree::split_in_space(ReferenceSet& set, std::size_t depth,
                                               const ObjectSplit& split) {
  const auto [left, right] = apply_object_split(set, split);
  return build_children(set.range, left, right, depth + 1);
}

BinaryTree::Subtree BinaryTree::build_children(const ClosedTimeRange& range, const ReferenceSet& left_set,
                                               const ReferenceSet& right_set, std::size_t depth) {
  Subtree left, right;
  invoke_both(
      left_set.size() + right_set.size() >= kParallelSet, [&] { left = build_node(left_set, depth); },
      [&] { right = build_node(right_set, depth); });
  if (left.node == nullptr || right.node == nullptr) throw BuildCancelled();  // tasks were skipped
  return make_inner(range, left, right);
}

BinaryTree::Subtree BinaryTree::make_leaf(const ReferenceSet& set) {
  BinaryLeaf* leaf = arenas_.local().make<BinaryLeaf>();
  const Reference& reference = set.references[0];
  const BuildMesh& mesh = context_.meshes[reference.mesh];
  leaf->packed_bounds = PackedBounds(reference.bounds());
  leaf->range = set.range;
  leaf->subtree_leaves = 1;
  leaf->meshlet = &context_.meshlets[reference.mesh].meshlets()[reference.meshlet];
  leaf->mesh = reference.mesh;
  leaf->segments = mesh.is_static() ? BuildMesh::SegmentRange{0, 0} : mesh.segments_in(set.range);
  leaf->is_indexed = false;
  const double length = static_cast<double>(set.range.last) - set.range.begin;
  context_.progress.add(static_cast<double>(set.size()) * length / total_work_);
  return {leaf, leaf_costs(*leaf)};
}

BinaryTree::Subtree BinaryTree::make_inner(const ClosedTimeRange& range, const Subtree& left,
                                           const Subtree& right) {
  BinaryInner* inner = arenas_.local().make<BinaryInner>();
  const std::array children{TimedBounds{left.node->bounds(), left.node->range},
                            TimedBounds{right.node->bounds(), right.node->range}};
  inner->packed_bounds = PackedBounds(merged_bounds(range, children));
  inner->range = range;
  inner->subtree_leaves = left.node->subtree_leaves + right.node->subtree_leaves;
  inner->set_children(*left.node, *right.node);
  return {inner, share_slots(*inner, left.costs, right.costs, context_.price)};
}

}  // namespace stbvh
