#include "harness/structures/gallery/gallery_tree.h"

#include <algorithm>
#include <numeric>

#include "builder/encoder.h"
#include "builder/mesh_parts.h"
#include "harness/scenes/scene_views.h"
#include "harness/structures/build_meter.h"
#include "isolated.h"
#include "layout/node_slots.h"
#include "mesh_table.h"
#include "traverse/kernel_table.h"

namespace stbvh::harness::gallery {

GalleryKernels own_kernels() {
  const KernelTable& kernels = kernel_table(default_isa(), Precision::kWatertight);
  return {kernels.intersect, kernels.intersect_counted, kernels.occluded};
}

const MethodKernels& method_kernels() {
  switch (default_isa()) {
    case Isa::kScalar:
      return kScalarMethods;
    case Isa::kAvx2:
      return kAvx2Methods;
    case Isa::kAvx512:
      break;
  }
  return kAvx512Methods;
}

namespace {

std::vector<OutlinedChild> own_children_at(const GalleryView& view, Link link, float time) {
  const std::byte* const data = view.data + unit_of(link) * kUnitBytes;
  ClosedTimeRange range{view.time_begin, view.time_last};
  if (kind_of(link) == LinkKind::kLinearNode)
    range.begin = reinterpret_cast<const LinearNode*>(data)->time_begin;
  const NodeSlots node = read_node(kind_of(link), data, range);
  std::vector<OutlinedChild> children;
  for (const NodeSlot& slot : node.used()) {
    if (!(time >= slot.range.begin && time <= slot.range.last)) continue;
    const auto face = [&](Plane plane) {
      return slot.planes[plane] + (time - slot.range.begin) * slot.slopes[plane];
    };
    children.push_back({slot.link, corners_of({{face(kLowerX), face(kLowerY), face(kLowerZ)},
                                               {face(kUpperX), face(kUpperY), face(kUpperZ)}})});
  }
  return children;
}

}  // namespace

WrittenTree write_own_nodes(BuildContext& context, BinaryNode& root) {
  const Encoder encoder(context, &root, kNoLimit);
  std::vector<std::uint32_t> records(context.meshes.size());
  std::iota(records.begin(), records.end(), 0u);
  Block block({}, encoder.bytes());
  const Link link = encoder.encode(block.data(), 0, records);
  return {std::move(block), link, own_kernels(), own_children_at, nullptr};
}

GalleryTree::GalleryTree(const Scene& scene, const Method& method, unsigned threads,
                         const BuildProgress& progress) {
  const BuildMeter meter(threads);
  isolated([&] { build(scene, method, progress); });
  record_.build_s = meter.seconds();
  record_.resident_bytes = meter.resident_growth();
}

void GalleryTree::build(const Scene& scene, const Method& method, const BuildProgress& progress) {
  const SceneViews views(scene);
  const BuildCallbacks callbacks{.allocate = {}, .release = {}, .temporary_memory = {}, .progress = progress};
  BuildContext context(method.settings, callbacks);
  context.meshes.reserve(views.meshes().size());
  for (std::size_t i = 0; i < views.meshes().size(); ++i) add_mesh(context, views.meshes()[i], i);
  context.progress.start();
  method.prepare ? method.prepare(context) : make_meshlets(context);
  {
    const std::unique_ptr<TopDown> builder = method.make_builder(context);
    BinaryNode* const root = builder->build();
    if (root != nullptr) tree_ = std::make_unique<WrittenTree>(method.write(context, *root));
    const ReferenceSet& all = builder->all();
    view_.time_begin = all.range.begin;
    view_.time_last = all.range.last;
    const Box4 whole = all.bounds.whole();
    for (int axis = 0; axis < 3; ++axis) {
      view_.lower[axis] = whole.lower[axis];
      view_.upper[axis] = whole.upper[axis];
    }
    view_.lower[3] = view_.upper[3] = 0.0f;
  }
  context.progress.finish();

  record_.structure_bytes = sizeof *this + MeshTable::bytes_of(context.meshes);
  if (tree_ != nullptr) record_.structure_bytes += tree_->block.bytes() + tree_->method_bytes;
  record_.peak_bytes = context.memory.peak() + record_.structure_bytes;
  enter_steps(context.meshes, record_);
  records_ = MeshRecords(context.meshes);
  view_.meshes = records_.data();
  view_.empty = tree_ == nullptr;
  if (tree_ == nullptr) return;
  view_.data = tree_->block.data();
  view_.root = tree_->root;
  view_.method = tree_->method.get();
}

bool GalleryTree::intersect_one(const Ray& ray, Hit& hit) const {
  return tree_ != nullptr && tree_->kernels.intersect(view_, ray, hit);
}

bool GalleryTree::occluded_one(const Ray& ray) const {
  return tree_ != nullptr && tree_->kernels.occluded(view_, ray);
}

std::vector<Outline> GalleryTree::outlines_at(float time, std::size_t level) const {
  if (tree_ == nullptr || kind_of(view_.root) == LinkKind::kLeaf) return {};
  std::vector<Outline> outlines;
  std::vector<Link> nodes{view_.root};
  for (std::size_t at = 1; !nodes.empty(); ++at) {
    std::vector<Link> below;
    for (const Link node : nodes) {
      for (OutlinedChild& child : tree_->children_at(view_, node, time)) {
        const bool goes_on = at < level && kind_of(child.link) != LinkKind::kLeaf;
        if (goes_on) below.push_back(child.link);
        if (!goes_on) outlines.push_back(std::move(child.corners));
      }
    }
    nodes = std::move(below);
  }
  return outlines;
}

bool GalleryTree::intersect_one_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  return tree_ != nullptr && tree_->kernels.intersect_counted(view_, ray, hit, counters);
}

}  // namespace stbvh::harness::gallery
