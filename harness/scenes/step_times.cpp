#include "harness/scenes/step_times.h"

#include <cmath>
#include <cstddef>

namespace stbvh::harness {

bool are_equidistant(const std::vector<float>& times) {
  const double begin = times.front(), length = times.back() - begin;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double fraction = static_cast<double>(i) / static_cast<double>(times.size() - 1);
    const auto place = static_cast<float>(begin + length * fraction);
    if (std::nextafter(times[i], place) != place) return false;
  }
  return true;
}

}  // namespace stbvh::harness
