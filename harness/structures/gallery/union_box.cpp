/// `union`: one static box for all times in every node and leaf, as a renderer has it whose tree knows
/// nothing of motion. The floor of the comparison.
///
/// Stored: the kernels' static nodes. Built: object splits alone, by the surface areas of the boxes.
/// Traversed: by the kernels. Leaves hold all steps, as everywhere in the gallery.
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/object_splits.h"

namespace stbvh::harness::gallery {
namespace {

class UnionBoxes final : public ObjectSplits {
 public:
  using ObjectSplits::ObjectSplits;

 private:
  void fit(ReferenceSet& set) const override {
    for (Reference& reference : set.references) {
      const Box4 whole = reference.bounds().whole();
      reference = make_reference({whole, whole}, reference.mesh, reference.meshlet);
    }
    set.update_bounds();
  }
};

}  // namespace

StructurePtr build_union(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_in_own_nodes<UnionBoxes>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
