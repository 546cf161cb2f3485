#include "harness/hard_cases/catalogue.h"

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

bool HardFamily::admits(std::string_view structure) const {
  if (is_in_gallery(structure)) return is_exact(structure);
  switch (askable) {
    case Askable::kAll:
      return true;
    case Askable::kOurs:
      return structure.starts_with("stbvh") && structure != "stbvh-beside";
    case Askable::kDirect:
      return structure.starts_with("stbvh-direct") || structure == "stbvh-batch";
  }
  return false;
}

std::span<const HardFamily> hard_families() {
  static const std::vector<HardFamily> families = [] {
    std::vector<HardFamily> all;
    add_closed_families(all);
    add_time_families(all);
    add_uneven_families(all);
    add_scale_families(all);
    add_thin_families(all);
    add_flat_families(all);
    add_ground_families(all);
    add_motion_families(all);
    add_range_families(all);
    add_invalid_families(all);
    return all;
  }();
  return families;
}

const HardFamily* find_hard_family(std::string_view name) {
  for (const HardFamily& family : hard_families()) {
    if (family.name == name) return &family;
  }
  return nullptr;
}

}  // namespace stbvh::harness
