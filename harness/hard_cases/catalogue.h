/// The parts that the catalogue is put together from.
#pragma once

#include <vector>

#include "harness/hard_cases/hard_case.h"

namespace stbvh::harness {

void add_closed_families(std::vector<HardFamily>& families);
void add_time_families(std::vector<HardFamily>& families);
void add_uneven_families(std::vector<HardFamily>& families);
void add_scale_families(std::vector<HardFamily>& families);
void add_thin_families(std::vector<HardFamily>& families);
void add_flat_families(std::vector<HardFamily>& families);
void add_ground_families(std::vector<HardFamily>& families);
void add_motion_families(std::vector<HardFamily>& families);
void add_range_families(std::vector<HardFamily>& families);
void add_invalid_families(std::vector<HardFamily>& families);

}  // namespace stbvh::harness
