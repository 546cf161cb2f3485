/// `stbvh-paper`: the spatial-temporal BVH as its paper has it (Woop, Afra, Benthin, HPG 2017, sections 3.2
/// and 3.3), on our nodes and leaves.
///
/// Stored: the kernels' nodes and leaves. Built: at each set the cheaper of the best object split and of the
/// one temporal split, at the step boundary nearest to the centre; C_leaf counts primitive segments, C_T =
/// C_I = 1. A set of one meshlet is a leaf unless splitting its time is cheaper than the leaf, which counts
/// all its segments. Traversed: by the kernels.
///
/// Departures: a leaf is one meshlet, of up to eight triangles, as everywhere in the gallery; lines are
/// tightest at the centre, nodes are collapsed at least cost. That the split costs C_T, and that a set which
/// is cheaper as a leaf stays one, concerns single meshlets only: larger sets do not fit into a leaf.
#include "builder/mbsah.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/mbsah_builder.h"

namespace stbvh::harness::gallery {
namespace {

class PaperBuilder final : public MbsahBuilder {
 public:
  using MbsahBuilder::MbsahBuilder;

 private:
  std::optional<Split> choose(const ReferenceSet& set) const override {
    const std::optional<TemporalCost> temporal = temporal_split(set);
    if (set.size() == 1) {
      const double traversal = expected_area(set.bounds, set.range);
      if (temporal && temporal->cost + traversal < leaf_cost(set)) return temporal->halves;
      return std::nullopt;
    }
    const auto [object, cost] = object_split(set);
    if (temporal && temporal->cost < cost) return temporal->halves;
    return object;
  }
};

}  // namespace

StructurePtr build_stbvh_paper(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_in_own_nodes<PaperBuilder>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
