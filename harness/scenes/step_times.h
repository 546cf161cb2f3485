/// When the steps of a mesh are.
#pragma once

#include <vector>

namespace stbvh::harness {

/// Whether two times or more are as far from each other, within one float each: then they are taken as such,
/// so that Embree can be compared.
bool are_equidistant(const std::vector<float>& times);

}  // namespace stbvh::harness
