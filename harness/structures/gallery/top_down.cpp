#include "harness/structures/gallery/top_down.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "builder/leaf_survey.h"
#include "builder/make_references.h"
#include "builder/mbsah.h"
#include "builder/merged_bounds.h"
#include "builder/temporal_split.h"

namespace stbvh::harness::gallery {
namespace {

constexpr std::size_t kParallelSet = 1024;    ///< sets from this size on are built as tasks of their own
constexpr std::size_t kSplitDepthLimit = 56;  ///< below, sets are only halved
static_assert(kSplitDepthLimit + 32 <= kMaxLevels, "the traversal's stacks hold no deeper tree");

template <typename F, typename G>
void invoke_both(bool parallel, const F& f, const G& g) {
  if (parallel) return tbb::parallel_invoke(f, g);
  f();
  g();
}

}  // namespace

TopDown::TopDown(BuildContext& context)
    : context_(context), arenas_([&context] { return Arena(context.memory); }) {}

BinaryNode* TopDown::build() {
  const std::size_t count = reference_count();
  if (count == 0) return nullptr;
  TemporaryArray<Reference> storage(context_.memory, count);
  all_ = make_references(storage.span());
  fit(all_);
  if (all_.size() == 0) return nullptr;
  context_.price = price(all_);
  total_work_ = static_cast<double>(all_.size()) * std::max(1e-30, static_cast<double>(all_.range.length()));
  BinaryNode* const root = build_root(all_).node;
  all_.references = {};
  collapse(*root);
  return root;
}

std::size_t TopDown::reference_count() const {
  std::size_t count = 0;
  for (const MeshletSet& set : context_.meshlets) count += set.meshlets().size();
  return count;
}

BytePrice TopDown::price(const ReferenceSet& all) const {
  return LeafSurvey(context_, all).usual_price();
}

ReferenceSet TopDown::make_references(std::span<Reference> storage) {
  return stbvh::make_references(context_, storage);
}

std::optional<Split> TopDown::choose(const ReferenceSet& set) const {
  const std::optional<TemporalSplit> temporal = find_temporal_split(context_, set);
  if (temporal && temporal->wanted_share >= kTemporalShare) return temporal->halves;
  if (set.size() == 1) return std::nullopt;
  return find_object_split(set);
}

std::pair<ReferenceSet, ReferenceSet> TopDown::split_in_space(ReferenceSet& set,
                                                              const ObjectSplit& split) const {
  return apply_object_split(set, split);
}

void TopDown::enter_leaf(const ReferenceSet& set, BinaryLeaf& leaf) {
  const Reference& reference = set.references[0];
  leaf.range = set.range;
  leaf.mesh = reference.mesh;
  leaf.meshlet = &meshlet(reference);
}

LinearBounds TopDown::inner_bounds(const ReferenceSet& set, const BinaryNode& left,
                                   const BinaryNode& right) const {
  const std::array children{TimedBounds{left.bounds(), left.range}, TimedBounds{right.bounds(), right.range}};
  return merged_bounds(set.range, children);
}

ClosedTimeRange TopDown::inner_range(const ReferenceSet& set, const BinaryNode&, const BinaryNode&) const {
  return set.range;
}

TopDown::Subtree TopDown::build_root(ReferenceSet& set) {
  if (!parts_still_from_moving()) return build_node(set, 0);
  const auto is_static = [&](const Reference& reference) {
    return context_.meshes[reference.mesh].is_static();
  };
  const auto moving = std::partition(set.references.begin(), set.references.end(), is_static);
  const auto count = static_cast<std::size_t>(moving - set.references.begin());
  if (count == 0 || count == set.size()) return build_node(set, 0);
  return build_sides(set, set.split_at(count), 1);
}

TopDown::Subtree TopDown::build_node(ReferenceSet set, std::size_t depth) {
  context_.progress.check();
  std::optional<Split> split;
  if (depth < kSplitDepthLimit) {
    split = choose(set);
  } else if (set.size() > 1) {
    split = ObjectSplit();
  }
  if (!split || (is_leaf(set) && !std::holds_alternative<TimeHalves>(*split))) return make_leaf(set);
  if (const auto* const halves = std::get_if<TimeHalves>(&*split)) return build_halves(set, *halves, depth);
  return build_sides(set, split_in_space(set, std::get<ObjectSplit>(*split)), depth + 1);
}

TopDown::Subtree TopDown::build_halves(const ReferenceSet& set, const TimeHalves& halves, std::size_t depth) {
  Subtree subtrees[2];
  const auto build_half = [&](std::size_t half) {
    TemporaryArray<Reference> storage(context_.memory, set.size());
    ReferenceSet remade = remake_references(context_, set, halves[half], storage.span());
    fit(remade);
    if (remade.size() > 0) subtrees[half] = build_node(remade, depth + 1);
  };
  invoke_both(
      set.size() >= kParallelSet, [&] { build_half(0); }, [&] { build_half(1); });
  const auto& [first, second] = subtrees;
  if (first.node == nullptr || second.node == nullptr) return first.node != nullptr ? first : second;
  return make_inner(set, first, second);
}

TopDown::Subtree TopDown::build_sides(const ReferenceSet& set,
                                      const std::pair<ReferenceSet, ReferenceSet>& sides, std::size_t depth) {
  Subtree left, right;
  invoke_both(
      set.size() >= kParallelSet, [&] { left = build_node(sides.first, depth); },
      [&] { right = build_node(sides.second, depth); });
  return make_inner(set, left, right);
}

TopDown::Subtree TopDown::make_leaf(const ReferenceSet& set) {
  BinaryLeaf* const leaf = arena().make<BinaryLeaf>();
  enter_leaf(set, *leaf);
  leaf->packed_bounds = PackedBounds(set.bounds);
  leaf->subtree_leaves = 1;
  const BuildMesh& mesh = context_.meshes[leaf->mesh];
  leaf->segments = mesh.is_static() ? BuildMesh::SegmentRange{0, 0} : mesh.segments_in(leaf->range);
  leaf->is_indexed = false;
  context_.progress.add(static_cast<double>(set.size()) * static_cast<double>(set.range.length()) /
                        total_work_);
  return {leaf, leaf_costs(*leaf)};
}

TopDown::Subtree TopDown::make_inner(const ReferenceSet& set, const Subtree& left, const Subtree& right) {
  BinaryInner* const inner = arena().make<BinaryInner>();
  inner->packed_bounds = PackedBounds(inner_bounds(set, *left.node, *right.node));
  inner->range = inner_range(set, *left.node, *right.node);
  inner->subtree_leaves = left.node->subtree_leaves + right.node->subtree_leaves;
  inner->set_children(*left.node, *right.node);
  return {inner, share_slots(*inner, left.costs, right.costs, context_.price)};
}

}  // namespace stbvh::harness::gallery
