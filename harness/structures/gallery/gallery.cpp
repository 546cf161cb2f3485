#include "harness/structures/gallery/gallery.h"

#include <array>

namespace stbvh::harness::gallery {

std::span<const GalleryEntry> gallery_entries() {
  static constexpr std::array kEntries{
      GalleryEntry{"union", "one static box for all times in every node", build_union},
      GalleryEntry{"box-sequence", "a box at each step in every node, the segment looked up at each",
                   build_box_sequence},
      GalleryEntry{"box-sequence-tsah", "the same, built by the mean of the areas over time (T-SAH)",
                   build_box_sequence_tsah},
      GalleryEntry{"msbvh", "Gruenschloss's spatial splits on our builder, with box sequences", build_msbvh},
      GalleryEntry{"linear", "linear bounds over the whole shutter, no temporal split", build_linear},
  };
  return kEntries;
}

}  // namespace stbvh::harness::gallery
