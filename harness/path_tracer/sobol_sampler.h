/// Sample points of a pixel: Owen-scrambled Sobol, in pairs of dimensions.
///
/// Each pair is the two-dimensional Sobol sequence (Sobol 1967), shuffled and scrambled by a hash of its own
/// (Burley 2020, "Practical hash-based Owen scrambling", with the permutation of Laine and Karras 2011):
/// padding keeps pairs independent of each other, and each pair a (0, 2)-sequence.
#pragma once

#include <cstdint>

namespace stbvh::harness {

/// In [0, 1)^2.
struct SamplePoint {
  double x = 0, y = 0;
};

/// Point `index` of the shuffled and scrambled pair `seed`: the first 2^m of them are a (0, m, 2)-net.
SamplePoint scrambled_sobol(std::uint32_t index, std::uint32_t seed);

/// The coordinates of one sample of one pixel: the same for equal arguments, whatever was drawn elsewhere.
class SobolSampler {
 public:
  SobolSampler(std::uint64_t seed, std::uint64_t pixel, std::uint32_t sample);

  /// The pair `dimension`.
  SamplePoint pair(std::uint32_t dimension) const;
  double number(std::uint32_t dimension) const { return pair(dimension).x; }

 private:
  std::uint64_t stream_;
  std::uint32_t sample_;
};

}  // namespace stbvh::harness
