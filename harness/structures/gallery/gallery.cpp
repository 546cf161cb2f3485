#include "harness/structures/gallery/gallery.h"

#include <array>

namespace stbvh::harness::gallery {

std::span<const GalleryEntry> gallery_entries() {
  static constexpr std::array kEntries{
      GalleryEntry{"union", "one static box for all times in every node", build_union},
      GalleryEntry{"separate-2", "2 trees without motion, at the centres of 2 windows of the shutter",
                   build_separate<2>, nullptr, false},
      GalleryEntry{"separate-4", "the same with 4", build_separate<4>, nullptr, false},
      GalleryEntry{"separate-8", "the same with 8", build_separate<8>, nullptr, false},
      GalleryEntry{"separate-16", "the same with 16", build_separate<16>, nullptr, false},
      GalleryEntry{"separate-32", "the same with 32", build_separate<32>, nullptr, false},
      GalleryEntry{"slabs-12", "twelve slabs in space and time a child, on our builder (after Glassner 1988)",
                   build_slabs_12},
      GalleryEntry{"kd4", "a kd-tree over space and time, scalar", build_kd4, nullptr, true, true},
      GalleryEntry{"obb-linear", "oriented boxes that move linearly over the whole shutter (Hou et al. 2010)",
                   build_obb_linear},
      GalleryEntry{"linear", "linear bounds over the whole shutter, no temporal split", build_linear},
      GalleryEntry{"time-boxes", "a static box for each meshlet and segment, with its times",
                   build_time_boxes, time_boxes_obstacle},
      GalleryEntry{"box-sequence", "a box at each step in every node, the segment looked up at each",
                   build_box_sequence},
      GalleryEntry{"msbvh", "Gruenschloss's spatial splits on our builder, with box sequences", build_msbvh},
      GalleryEntry{"box-sequence-tsah", "the same, built by the mean of the areas over time (T-SAH)",
                   build_box_sequence_tsah},
      GalleryEntry{"stbvh-paper", "the STBVH to the letter of its paper: segments counted, greedy choice",
                   build_stbvh_paper},
      GalleryEntry{"stbvh-gated", "the same with Embree's gates before temporal splits", build_stbvh_gated},
      GalleryEntry{"no-leaf-cost", "ours, but a leaf costs as many segments as it holds", build_no_leaf_cost},
      GalleryEntry{"no-temporal-first", "ours, but time is split where that is cheapest at the moment",
                   build_no_temporal_first},
      GalleryEntry{"no-tight-lines", "ours, but lines go through the boxes at both ends, moved outwards",
                   build_no_tight_lines},
      GalleryEntry{"no-static-side", "ours, but what stands still is split with what moves",
                   build_no_static_side},
      GalleryEntry{"no-optimal-collapse", "ours, but the largest child is opened until there are eight",
                   build_no_optimal_collapse},
      GalleryEntry{"no-meshlets", "ours, but of single triangles, leaves where the splits arrive",
                   build_no_meshlets},
      GalleryEntry{"no-step-reduction", "ours, but with all steps that are given", build_no_step_reduction},
  };
  return kEntries;
}

}  // namespace stbvh::harness::gallery
