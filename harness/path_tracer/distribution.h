/// Choosing among things of different weight.
#pragma once

#include <cstddef>
#include <vector>

namespace stbvh::harness {

/// Indices drawn in proportion to weights.
class Distribution {
 public:
  struct Pick {
    std::size_t index = 0;
    double probability = 0;
    double rest = 0;  ///< the number that was drawn with, stretched to [0, 1) again
  };

  Distribution() = default;
  /// The weights are finite and not negative.
  explicit Distribution(const std::vector<double>& weights);

  /// Sum of all weights; where it is 0 nothing can be drawn.
  double total() const { return sums_.empty() ? 0 : sums_.back(); }
  double probability(std::size_t index) const;
  /// `number` is in [0, 1). Never picks what has no weight.
  Pick pick(double number) const;

 private:
  std::vector<double> sums_;  ///< of the weights up to each, including it
};

}  // namespace stbvh::harness
