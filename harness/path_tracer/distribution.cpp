#include "harness/path_tracer/distribution.h"

#include <algorithm>
#include <cmath>

namespace stbvh::harness {

Distribution::Distribution(const std::vector<double>& weights) {
  sums_.reserve(weights.size());
  double sum = 0;
  for (double weight : weights) sums_.push_back(sum += weight);
}

double Distribution::probability(std::size_t index) const {
  if (!(total() > 0)) return 0;
  return (sums_[index] - (index == 0 ? 0 : sums_[index - 1])) / total();
}

Distribution::Pick Distribution::pick(double number) const {
  const double target = number * total();
  auto found = std::upper_bound(sums_.begin(), sums_.end(), target);
  // Rounding may lead past the end: then the last that has weight.
  if (found == sums_.end()) found = std::lower_bound(sums_.begin(), sums_.end(), sums_.back());
  const auto index = static_cast<std::size_t>(found - sums_.begin());
  const double before = index == 0 ? 0 : sums_[index - 1];
  const double rest = std::clamp((target - before) / (*found - before), 0.0, std::nextafter(1.0, 0.0));
  return {index, probability(index), rest};
}

}  // namespace stbvh::harness
