/// `linear`: linear bounds over the whole shutter in every node and leaf, and no temporal split: what an
/// STBVH is without what makes it one (Woop et al. 2017, section 3.1 without 3.2). The control.
///
/// Stored: the kernels' linear and static nodes, with their lines, tightest at the centre over all steps.
/// Built: object splits alone. Traversed: by the kernels.
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/object_splits.h"

namespace stbvh::harness::gallery {

StructurePtr build_linear(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_in_own_nodes<ObjectSplits>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
