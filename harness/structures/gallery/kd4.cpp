/// `kd4`: a kd-tree over space and time, after Olsson (2007). The text was not to be had: what is here is
/// inferred from what is known of Mitsuba 0.6, which has such a tree for its shape `deformable`.
///
/// Stored: nodes of 8 bytes that split space at a plane or the shutter at a time; in each cell links to the
/// meshlets in it. All cells share one leaf of a meshlet, which holds all its steps: a leaf of the steps that
/// a cell needs would be a copy of vertices for each of them.
/// Built: kd4_builder.cpp, with the surface area heuristic as it is modified for time: the chance of a part
/// of space is its share of the surface, that of a part of time its share of the duration, and the cheapest
/// split of both kinds is taken. Traversed: scalar, kd4_traverse.cpp.
///
/// Departs: Mitsuba switches clipping in time off, so that boxes never shrink behind a split in time; here
/// each split in time makes the boxes of both halves anew. References are boxes of meshlets, not of
/// triangles, with the costs of their test (Mitsuba: 15 and 20, and cells of up to 6 triangles). Planes are
/// chosen among 32 in each axis, or among all faces of small sets, times at the centre of the range. How many
/// references splits make is limited, and with it time and memory of the build.
#include "builder/mesh_parts.h"
#include "harness/scenes/scene_views.h"
#include "harness/structures/build_meter.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/kd4_builder.h"
#include "harness/structures/gallery/kd4_nodes.h"
#include "harness/structures/gallery/mesh_records.h"
#include "harness/structures/gallery/one_by_one.h"
#include "isolated.h"
#include "layout/node_slots.h"
#include "mesh_table.h"

namespace stbvh::harness::gallery {
namespace {

class KdTree final : public OneByOne<KdTree> {
 public:
  KdTree(const Scene& scene, unsigned threads, const BuildProgress& progress) {
    const BuildMeter meter(threads);
    isolated([&] { build(scene, progress); });
    record_.build_s = meter.seconds();
    record_.resident_bytes = meter.resident_growth();
  }

  const BuildRecord& build_record() const override { return record_; }
  bool intersect_one(const Ray& ray, Hit& hit) const override { return intersect_kd(view_, ray, hit); }
  bool occluded_one(const Ray& ray) const override { return occluded_kd(view_, ray); }
  bool has_counters() const override { return true; }
  bool intersect_one_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return intersect_kd_counted(view_, ray, hit, counters);
  }
  std::vector<Outline> outlines_at(float time, std::size_t level) const override;

 private:
  void build(const Scene& scene, const BuildProgress& progress);
  void write(const BuildContext& context, const KdBuilder& builder);

  MeshRecords records_;
  std::unique_ptr<Block> block_;  ///< leaves, behind them nodes, behind these the links of the cells
  KdView view_{};
  BuildRecord record_;
};

void KdTree::build(const Scene& scene, const BuildProgress& progress) {
  const SceneViews views(scene);
  const BuildCallbacks callbacks{.allocate = {}, .release = {}, .temporary_memory = {}, .progress = progress};
  BuildContext context(as_given(), callbacks);
  context.meshes.reserve(views.meshes().size());
  for (std::size_t i = 0; i < views.meshes().size(); ++i) add_mesh(context, views.meshes()[i], i);
  context.progress.start();
  make_meshlets(context);
  KdBuilder builder(context);
  view_.empty = !builder.build();
  if (!view_.empty) write(context, builder);
  context.progress.finish();

  records_ = MeshRecords(context.meshes);
  view_.meshes = records_.data();
  enter_steps(context.meshes, record_);
  record_.structure_bytes = sizeof *this + MeshTable::bytes_of(context.meshes);
  if (block_ != nullptr) record_.structure_bytes += block_->bytes();
  record_.peak_bytes = context.memory.peak() + record_.structure_bytes;
}

void KdTree::write(const BuildContext& context, const KdBuilder& builder) {
  std::vector<Link> leaves;
  std::size_t units = 0;
  for (std::size_t i = 0; i < context.meshes.size(); ++i) {
    const std::size_t leaf_units = inline_leaf_bytes(context.meshes[i].view().steps.size()) / kUnitBytes;
    for (std::size_t m = context.meshlets[i].meshlets().size(); m > 0; --m) {
      leaves.push_back(make_link(LinkKind::kLeaf, units));
      units += leaf_units;
    }
  }
  if (units > kMaxUnits) throw std::length_error("structure larger than 32 GiB");
  const std::size_t leaf_bytes = units * kUnitBytes;
  const std::size_t node_bytes = builder.node_count() * sizeof(KdNode);
  block_ = std::make_unique<Block>(BuildCallbacks{},
                                   leaf_bytes + node_bytes + builder.link_count() * sizeof(Link));
  std::size_t number = 0;
  for (std::uint32_t i = 0; i < context.meshes.size(); ++i) {
    for (const Meshlet& meshlet : context.meshlets[i].meshlets()) {
      std::byte* const out = block_->data() + unit_of(leaves[number++]) * kUnitBytes;
      write_inline_leaf(i, meshlet, 0, context.meshes[i].view().steps, out);
    }
  }
  auto* const nodes = reinterpret_cast<KdNode*>(block_->data() + leaf_bytes);
  auto* const links = reinterpret_cast<Link*>(block_->data() + leaf_bytes + node_bytes);
  builder.write(leaves, nodes, links);

  const KdCell& all = builder.all();
  view_.data = block_->data();
  view_.nodes = nodes;
  view_.links = links;
  view_.time_begin = all.range.begin;
  view_.time_last = all.range.last;
  for (int axis = 0; axis < 3; ++axis) {
    view_.lower[axis] = all.box.lower[axis];
    view_.upper[axis] = all.box.upper[axis];
  }
}

std::vector<Outline> KdTree::outlines_at(float time, std::size_t level) const {
  if (view_.empty) return {};
  std::vector<Outline> outlines;
  const auto visit = [&](const auto& self, const KdNode& node, std::array<Vec3f, 2> corners,
                         std::size_t at) -> void {
    if (at == level || node.axis() == KdAxis::kCell)
      return outlines.push_back(corners_of({corners[0], corners[1]}));
    const KdNode* const children = view_.nodes + node.first();
    if (node.axis() == KdAxis::kTime) return self(self, children[time >= node.position()], corners, at + 1);
    for (std::size_t side = 0; side < 2; ++side) {
      std::array<Vec3f, 2> part = corners;
      Vec3f& corner = part[1 - side];
      (node.axis() == KdAxis::kX   ? corner.x
       : node.axis() == KdAxis::kY ? corner.y
                                   : corner.z) = node.position();
      self(self, children[side], part, at + 1);
    }
  };
  visit(visit, view_.nodes[0],
        {Vec3f{view_.lower[0], view_.lower[1], view_.lower[2]},
         Vec3f{view_.upper[0], view_.upper[1], view_.upper[2]}},
        0);
  return outlines;
}

}  // namespace

StructurePtr build_kd4(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return std::make_unique<KdTree>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
