/// `box-sequence-tsah`: the nodes of `box-sequence`, built by the time-dependent surface area heuristic
/// (Bittner and Meister, Eurographics 2015, "T-SAH: Animation Optimized Bounding Volume Hierarchies"): the
/// cost of a node is the mean of its surface area over times.
///
/// Stored, traversed: as `box-sequence`.
/// Built: object splits, of which each compares the mean areas of the sequences of its sides: 32 bins in each
/// axis by the centroid at the centre of the shutter, an exact sweep below 17 references, as in the kernels.
/// Areas are compared at the steps of the finest mesh of a set, at 17 times at most.
///
/// Where it departs: theirs starts from the tree of one time and optimises it by taking nodes out and
/// inserting them elsewhere; ours is built top-down with the same measure. What stands still is a side of the
/// root, as in all trees of the gallery.
#include "harness/structures/gallery/mean_area.h"

namespace stbvh::harness::gallery {

StructurePtr build_box_sequence_tsah(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_of_pieces<MeanAreaBuilder>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
