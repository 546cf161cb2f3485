#include "harness/structures/gallery/gallery.h"

#include <array>

namespace stbvh::harness::gallery {

std::span<const GalleryEntry> gallery_entries() {
  static constexpr std::array kEntries{
      GalleryEntry{"union", "one static box for all times in every node", build_union},
      GalleryEntry{"slabs-12", "twelve slabs in space and time a child, on our builder (after Glassner 1988)",
                   build_slabs_12},
      GalleryEntry{"obb-linear", "oriented boxes that move linearly over the whole shutter (Hou et al. 2010)",
                   build_obb_linear},
      GalleryEntry{"linear", "linear bounds over the whole shutter, no temporal split", build_linear},
  };
  return kEntries;
}

}  // namespace stbvh::harness::gallery
