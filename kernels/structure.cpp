#include "stbvh/structure.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "builder/binary_tree.h"
#include "builder/collapse.h"
#include "builder/encoder.h"
#include "builder/merged_bounds.h"
#include "builder/mesh_parts.h"
#include "builder/step_bounds.h"
#include "isolated.h"
#include "layout/node_slots.h"
#include "layout/node_walk.h"
#include "stored_tree.h"
#include "traverse/kernel_table.h"
#include "tree_update.h"

namespace stbvh {

namespace {

/// Rays from one point, such as a camera's, meet the same nodes one after another.
bool come_from_one_point(const RayBatch& batch) {
  const Vec3f first = ray_at(batch, 0).origin;
  const auto is_there = [&](std::size_t i) {
    const Vec3f origin = ray_at(batch, i).origin;
    return origin.x == first.x && origin.y == first.y && origin.z == first.z;
  };
  return is_there(1) && is_there(batch.count / 2) && is_there(batch.count - 1);
}

template <typename Trace>
void one_by_one(const RayBatch& batch, const Trace& trace) {
  for (std::size_t i = 0; i < batch.count; ++i) {
    const Ray& ray = ray_at(batch, i);
    Hit hit;
    if (trace(ray, hit) && batch.report != nullptr) batch.report(batch.user, ray, hit);
  }
}

/// Without the rounding of the root's planes.
std::vector<TimedBounds> root_children(const BinaryTree& tree) {
  const BinaryNode* const root = tree.root();
  if (root == nullptr) return {};
  if (root->is_leaf()) return {{root->bounds(), root->range}};
  const WideChildren<const BinaryNode> children = wide_children(as_inner(*root));
  std::vector<TimedBounds> bounds;
  for (const BinaryNode* child : children.span()) bounds.push_back({child->bounds(), child->range});
  return bounds;
}

class StructureImpl final : public Structure {
 public:
  StructureImpl(BuildContext& context, const BuildCallbacks& callbacks, const BinaryTree& tree,
                const Encoder& encoder)
      : kernels_(kernel_table(default_isa(), context.settings.precision)),
        tree_(context.settings, callbacks, encoder.bytes()) {
    const std::vector<std::uint32_t> records = tree_.meshes.add(context, tree);
    tree_.is_empty = tree.root() == nullptr;
    if (!tree_.is_empty) {
      const Link root = encoder.encode(tree_.block.data(), 0, records);
      tree_.root = make_slot({tree.root()->bounds(), tree.range(), root});
    }
    tree_.root.range = tree.range();
    tree_.counts = encoder.counts();
    tree_.usual_area = tree_.counts.expected_area;
    tree_.temporal_splits = tree.temporal_splits();
    tree_.indexed_leaf_bytes =
        encoder.leaf_bytes() - static_cast<std::size_t>(tree_.counts.leaf_units) * kUnitBytes;
    show(stbvh::root_children(tree));
    make_statistics(
        std::max(context.memory.peak(), context.memory.current() + sizeof(StructureImpl) + tree_.bytes()));
    const bool is_limited = context.price.may_index || statistics_.indexed_leaves > 0;
    if (is_limited) {
      const auto wanted = static_cast<std::size_t>(tree.wanted_bytes()) + bytes_beside_block(context);
      statistics_.wanted_bytes = std::max(statistics_.structure_bytes, wanted);
    }
  }

  /// A tree that was saved.
  StructureImpl(StoredTree tree, std::size_t wanted_bytes)
      : kernels_(kernel_table(default_isa(), tree.settings.precision)), tree_(std::move(tree)) {
    show(tree_.is_empty ? std::vector<TimedBounds>() : root_children());
    make_statistics(sizeof(StructureImpl) + tree_.bytes());
    statistics_.wanted_bytes = std::max(statistics_.structure_bytes, wanted_bytes);
  }

  /// What a structure takes without its nodes and leaves.
  static std::size_t bytes_beside_block(const BuildContext& context) {
    return sizeof(StructureImpl) + MeshTable::bytes_of(context.meshes);
  }

  std::optional<UpdateStatistics> update(std::span<const MeshView> meshes,
                                         std::span<const MeshUpdate> updates,
                                         const BuildCallbacks& callbacks) override {
    std::size_t peak_bytes = 0;
    std::optional<UpdateStatistics> result;
    isolated([&] { result = update_tree(tree_, meshes, updates, callbacks, peak_bytes); });
    if (!result) return result;
    const std::size_t usual = statistics_.wanted_bytes;
    show(root_children());
    make_statistics(peak_bytes);
    statistics_.wanted_bytes = std::max(statistics_.structure_bytes, usual);
    return result;
  }

  bool intersect(const Ray& ray, Hit& hit, const HitFilter* filter) const override {
    return filter == nullptr ? kernels_.intersect(view_, ray, hit)
                             : kernels_.intersect_filtered(view_, ray, hit, *filter);
  }
  bool occluded(const Ray& ray, const HitFilter* filter) const override {
    return filter == nullptr ? kernels_.occluded(view_, ray)
                             : kernels_.occluded_filtered(view_, ray, *filter);
  }
  bool intersect_on(Isa isa, const Ray& ray, Hit& hit, const HitFilter* filter) const override {
    const KernelTable& kernels = kernel_table(isa, tree_.settings.precision);
    return filter == nullptr ? kernels.intersect(view_, ray, hit)
                             : kernels.intersect_filtered(view_, ray, hit, *filter);
  }
  bool occluded_on(Isa isa, const Ray& ray, const HitFilter* filter) const override {
    const KernelTable& kernels = kernel_table(isa, tree_.settings.precision);
    return filter == nullptr ? kernels.occluded(view_, ray) : kernels.occluded_filtered(view_, ray, *filter);
  }
  void intersect(const RayBatch& batch) const override {
    if (waits_for_memory(batch)) return kernels_.intersect_in_flight(view_, batch);
    one_by_one(batch, [&](const Ray& ray, Hit& hit) { return intersect(ray, hit, batch.filter); });
  }
  void occluded(const RayBatch& batch) const override {
    if (waits_for_memory(batch)) return kernels_.occluded_in_flight(view_, batch);
    one_by_one(batch, [&](const Ray& ray, Hit&) { return occluded(ray, batch.filter); });
  }
  void intersect_on(Isa isa, const RayBatch& batch) const override {
    kernel_table(isa, tree_.settings.precision).intersect_in_flight(view_, batch);
  }
  void occluded_on(Isa isa, const RayBatch& batch) const override {
    kernel_table(isa, tree_.settings.precision).occluded_in_flight(view_, batch);
  }
  bool intersect_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return kernels_.intersect_counted(view_, ray, hit, counters);
  }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const override {
    return kernels_.occluded_counted(view_, ray, counters);
  }

  Box3f bounds_at(float time) const override {
    Box4 box = Box4::empty();
    for (const TimedBounds& child : root_children_) {
      if (!(time >= child.range.begin && time <= child.range.last)) continue;
      const float length = child.range.length();
      const float f = length > 0.0f ? (time - child.range.begin) / length : 0.0f;
      const F32x4 f0(1.0f - f), f1(f);
      const auto& [begin, end] = child.bounds;
      if (child.bounds.is_static()) {  // weights that sum up to one would round
        box.extend(begin);
        continue;
      }
      const F32x4 largest = max(max(abs(begin.lower), abs(end.lower)), max(abs(begin.upper), abs(end.upper)));
      const F32x4 pad = largest * F32x4(0x1p-21f);
      box.extend(Box4{f0 * begin.lower + f1 * end.lower - pad, f0 * begin.upper + f1 * end.upper + pad});
    }
    return to_box3f(box);
  }

  const BuildStatistics& statistics() const override { return statistics_; }

  void visit_nodes(NodeVisitor& visitor) const override { walk_nodes(view_, visitor); }

  const StoredTree& stored() const override { return tree_; }

  std::uint64_t tree_hash() const override {
    std::uint64_t hash = 0xcbf29ce484222325u ^ view_.root;
    for (std::size_t i = 0; i < tree_.space.end() * kUnitBytes; i += sizeof(std::uint64_t)) {
      std::uint64_t word;
      std::memcpy(&word, tree_.block.data() + i, sizeof word);
      hash = (hash ^ word) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return hash;
  }

 private:
  /// Else rays in flight only cost: a seventh where a tree stays in the caches (docs/performance.md).
  bool waits_for_memory(const RayBatch& batch) const {
    constexpr std::size_t kCached = 2u << 20;
    return tree_.block.bytes() > kCached && batch.count > 1 && !come_from_one_point(batch);
  }

  /// Makes the tree what rays are traced through.
  void show(std::vector<TimedBounds> root_children) {
    root_children_ = std::move(root_children);
    view_ = {};
    view_.data = tree_.block.data();
    view_.meshes = tree_.meshes.records();
    view_.root = tree_.root.link;
    view_.empty = tree_.is_empty;
    view_.time_begin = tree_.root.range.begin;
    view_.time_last = tree_.root.range.last;
    Box4 all = Box4::empty();
    for (const TimedBounds& child : root_children_) all.extend(child.bounds.whole());
    for (int axis = 0; axis < 3; ++axis) {
      view_.lower[axis] = all.lower[axis];
      view_.upper[axis] = all.upper[axis];
    }
  }

  std::vector<TimedBounds> root_children() const {
    const auto& [planes, slopes, link, range] = tree_.root;
    if (kind_of(link) == LinkKind::kLeaf) return {{tree_.root.bounds(), range}};
    const NodeSlots node = read_node(kind_of(link), tree_.block.data() + unit_of(link) * kUnitBytes, range);
    std::vector<TimedBounds> children;
    for (const NodeSlot& child : node.used()) children.push_back({child.bounds(), child.range});
    return children;
  }

  void make_statistics(std::size_t peak_bytes) {
    statistics_ = {};
    tree_.counts.enter_in(statistics_);
    statistics_.leaf_bytes =
        static_cast<std::size_t>(tree_.counts.leaf_units) * kUnitBytes + tree_.indexed_leaf_bytes;
    statistics_.temporal_splits = tree_.temporal_splits;
    statistics_.structure_bytes = sizeof(StructureImpl) + tree_.bytes();
    statistics_.wanted_bytes = statistics_.structure_bytes;
    statistics_.peak_bytes = std::max(peak_bytes, statistics_.structure_bytes);
    tree_.meshes.enter_in(statistics_);
  }

  const KernelTable& kernels_;
  StoredTree tree_;
  std::vector<TimedBounds> root_children_;
  StructureView view_{};
  BuildStatistics statistics_;
};

MemoryLimit over_limit(const BuildSettings& settings, std::size_t needed_bytes) {
  if (needed_bytes == 0) {
    return {"the build takes more memory than the limit of its peak, " +
                std::to_string(settings.max_peak_bytes) + " bytes",
            0};
  }
  return {"the smallest structure takes " + std::to_string(needed_bytes) + " bytes, more than the limit of " +
              std::to_string(settings.max_bytes),
          needed_bytes};
}

/// Builds `tree` and chooses its leaves so that both limits are kept: smaller and smaller trees, until one is
/// small enough. `beside` is what a structure takes without nodes and leaves.
Encoder build_within_limits(BuildContext& context, BinaryTree& tree, std::size_t beside) {
  constexpr int kAttempts = 6;
  const auto without = [](std::size_t limit, std::size_t bytes) { return limit - std::min(limit, bytes); };
  const std::size_t most = without(context.settings.max_bytes, beside);
  double aim = static_cast<double>(most);
  for (int attempt = 1;; ++attempt) {
    std::size_t needed = 0;
    double shrink = 0.7;
    try {
      tree.build(aim);
      const std::size_t left = without(context.settings.max_peak_bytes, context.memory.current() + beside);
      Encoder encoder(context, tree.root(), std::min(most, left));
      if (encoder.bytes() <= std::min(most, left) && beside <= context.settings.max_bytes) return encoder;
      if (encoder.bytes() + beside > context.settings.max_bytes) needed = encoder.bytes() + beside;
      shrink = 0.9 * static_cast<double>(std::min(most, left)) /
               static_cast<double>(std::max<std::size_t>(encoder.bytes(), 1));
    } catch (const BuildMemory::LimitReached&) {
    }
    if (aim == 0.0) throw over_limit(context.settings, needed);
    aim = attempt + 1 < kAttempts ? std::min(aim, tree.wanted_bytes()) * shrink : 0.0;
  }
}

/// Rays side by side, and as many answers.
template <typename Answer>
struct SideBySide {
  const Ray* rays;
  Answer* answers;

  Answer& of(const Ray& ray) const { return answers[&ray - rays]; }
};

template <typename Answer>
RayBatch batch_of(std::span<const Ray> rays, SideBySide<Answer>& both, const HitFilter* filter,
                  void (*report)(void* user, const Ray& ray, const Hit& hit)) {
  return {rays.data(), sizeof(Ray), rays.size(), report, &both, filter};
}

}  // namespace

std::unique_ptr<Structure> structure_of(StoredTree tree, std::size_t wanted_bytes) {
  return std::make_unique<StructureImpl>(std::move(tree), wanted_bytes);
}

void Structure::intersect(std::span<const Ray> rays, std::span<Hit> hits, const HitFilter* filter) const {
  for (Hit& hit : hits) hit.geom_id = kInvalidId;
  SideBySide<Hit> both{rays.data(), hits.data()};
  intersect(batch_of(rays, both, filter, [](void* user, const Ray& ray, const Hit& hit) {
    static_cast<const SideBySide<Hit>*>(user)->of(ray) = hit;
  }));
}

void Structure::occluded(std::span<const Ray> rays, std::span<bool> occluded, const HitFilter* filter) const {
  std::ranges::fill(occluded, false);
  SideBySide<bool> both{rays.data(), occluded.data()};
  this->occluded(batch_of(rays, both, filter, [](void* user, const Ray& ray, const Hit&) {
    static_cast<const SideBySide<bool>*>(user)->of(ray) = true;
  }));
}

std::unique_ptr<Structure> Structure::build(std::span<const MeshView> meshes, const BuildSettings& settings,
                                            const BuildCallbacks& callbacks) {
  std::unique_ptr<Structure> structure;
  const auto build_here = [&] {
    BuildContext context(settings, callbacks);
    context.meshes.reserve(meshes.size());
    for (std::size_t i = 0; i < meshes.size(); ++i) add_mesh(context, meshes[i], i);
    context.progress.start();
    BinaryTree tree(context);
    tell_step_bounds(context, callbacks);
    const Encoder encoder = build_within_limits(context, tree, StructureImpl::bytes_beside_block(context));
    structure = std::make_unique<StructureImpl>(context, callbacks, tree, encoder);
    context.progress.finish();
  };
  try {
    isolated(build_here);
  } catch (const BuildMemory::LimitReached&) {
    throw over_limit(settings, 0);
  }
  return structure;
}

}  // namespace stbvh
