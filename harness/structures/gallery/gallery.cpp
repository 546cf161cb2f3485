#include "harness/structures/gallery/gallery.h"

#include <array>

namespace stbvh::harness::gallery {

std::span<const GalleryEntry> gallery_entries() {
  static constexpr std::array kEntries{
      GalleryEntry{"kd4", "a kd-tree over space and time, scalar", build_kd4, nullptr, true, true},
      GalleryEntry{"separate-2", "2 trees without motion, at the centres of 2 windows of the shutter",
                   build_separate<2>, nullptr, false},
      GalleryEntry{"separate-4", "the same with 4", build_separate<4>, nullptr, false},
      GalleryEntry{"separate-8", "the same with 8", build_separate<8>, nullptr, false},
      GalleryEntry{"separate-16", "the same with 16", build_separate<16>, nullptr, false},
      GalleryEntry{"separate-32", "the same with 32", build_separate<32>, nullptr, false},
      GalleryEntry{"time-boxes", "a static box for each meshlet and segment, with its times",
                   build_time_boxes, time_boxes_obstacle},
      GalleryEntry{"union", "one static box for all times in every node", build_union},
      GalleryEntry{"linear", "linear bounds over the whole shutter, no temporal split", build_linear},
  };
  return kEntries;
}

}  // namespace stbvh::harness::gallery
