/// `time-boxes`: a static box for each primitive and time interval, as Cycles has in its own tree with motion
/// steps (BVHBuild::add_reference_triangles of Blender, of which excerpts were read; there is no paper).
///
/// Stored: the kernels' static and spatial-temporal nodes, without slopes: a box and a time range for each
/// child. Built: a reference for each meshlet and segment; object splits alone, by the surface areas of the
/// boxes and the number of references, as if all were alive at once. A node's times are the hull of those
/// below it, its box is their union. Traversed: by the kernels.
///
/// Departs: Cycles divides the shutter into equal intervals, as many for all meshes as the user's setting
/// says, and bounds triangles; here the intervals of a mesh are its segments, and hold meshlets.
#include <fmt/format.h>

#include "builder/motion_bounds.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/object_splits.h"

namespace stbvh::harness::gallery {
namespace {

/// Each takes some 600 bytes at the peak of a build.
constexpr std::size_t kMostReferences = 20'000'000;
/// That share a meshlet at least, in connected meshes.
constexpr std::size_t kTrianglesPerMeshlet = 5;

using Intervals = std::vector<ClosedTimeRange>;

/// Cuts `range` at all step boundaries inside it: each float time is in one interval.
void append_segments(const BuildMesh& mesh, const ClosedTimeRange& range, Intervals& out) {
  const std::optional<float> boundary = mesh.central_boundary(range);
  if (!boundary) return out.push_back(range);
  for (const ClosedTimeRange& half : halves_at(range, *boundary)) append_segments(mesh, half, out);
}

ClosedTimeRange hull(const ClosedTimeRange& a, const ClosedTimeRange& b) {
  return {std::min(a.begin, b.begin), std::max(a.last, b.last)};
}

class TimeBoxes final : public ObjectSplits {
 public:
  explicit TimeBoxes(BuildContext& context) : ObjectSplits(context), intervals_(context.meshes.size()) {
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      const BuildMesh& mesh = context.meshes[i];
      const ClosedTimeRange alive = mesh.alive({0.0f, 1.0f});
      if (alive.begin <= alive.last) append_segments(mesh, alive, intervals_[i]);
    }
  }

 private:
  std::size_t meshlet_count(std::size_t mesh) const { return context().meshlets[mesh].meshlets().size(); }

  std::size_t reference_count() const override {
    std::size_t count = 0;
    for (std::size_t i = 0; i < intervals_.size(); ++i) count += intervals_[i].size() * meshlet_count(i);
    return count;
  }

  /// Number i of a mesh's references is its meshlet i % meshlets in its interval i / meshlets.
  ReferenceSet make_references(std::span<Reference> storage) override {
    ReferenceSet set;
    set.range = {1.0f, 0.0f};
    std::size_t out = 0;
    for (std::uint32_t i = 0; i < intervals_.size(); ++i) {
      const std::span<const Meshlet> meshlets = context().meshlets[i].meshlets();
      std::uint32_t number = 0;
      for (const ClosedTimeRange& interval : intervals_[i]) {
        context().progress.poll();
        const MotionSamples samples(context().meshes[i], interval);
        for (const Meshlet& meshlet : meshlets) {
          const Box4 box = motion_bounds(context().meshes[i], samples, meshlet.used_vertices()).whole();
          storage[out++] = make_reference({box, box}, i, number++);
        }
        if (!meshlets.empty()) set.range = hull(set.range, interval);
      }
    }
    set.references = storage.first(out);
    set.update_bounds();
    return set;
  }

  void enter_leaf(const ReferenceSet& set, BinaryLeaf& leaf) override {
    const Reference& reference = set.references[0];
    const std::size_t meshlets = meshlet_count(reference.mesh);
    leaf.mesh = reference.mesh;
    leaf.meshlet = &context().meshlets[reference.mesh].meshlets()[reference.meshlet % meshlets];
    leaf.range = intervals_[reference.mesh][reference.meshlet / meshlets];
  }

  LinearBounds inner_bounds(const ReferenceSet& set, const BinaryNode&, const BinaryNode&) const override {
    return set.bounds;
  }
  ClosedTimeRange inner_range(const ReferenceSet&, const BinaryNode& left,
                              const BinaryNode& right) const override {
    return hull(left.range, right.range);
  }
  BytePrice price(const ReferenceSet&) const override { return {}; }

  std::vector<Intervals> intervals_;  ///< of each mesh
};

}  // namespace

std::string time_boxes_obstacle(const Scene& scene) {
  std::size_t references = 0;
  for (const Mesh& mesh : scene.meshes)
    references += (mesh.triangle_count() + kTrianglesPerMeshlet - 1) / kTrianglesPerMeshlet *
                  std::max<std::size_t>(mesh.segment_count(), 1);
  if (references <= kMostReferences) return "";
  return fmt::format("it would have some {} million references, a meshlet in a segment each",
                     references / 1'000'000);
}

StructurePtr build_time_boxes(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_in_own_nodes<TimeBoxes>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
