/// Sample points: nets in each pair of dimensions, independent between pairs and pixels.
#include "harness/path_tracer/sobol_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace stbvh::harness {
namespace {

TEST(SobolSampler, EveryPowerOfTwoIsANet) {
  for (std::uint32_t seed : {0u, 1u, 77u, 0xFFFFFFFFu}) {
    for (std::uint32_t m = 0; m <= 10; ++m) {
      // In each way to cut the square into 2^m boxes of sides that are powers of two: one point in each.
      for (std::uint32_t a = 0; a <= m; ++a) {
        std::set<std::pair<int, int>> boxes;
        for (std::uint32_t i = 0; i < 1u << m; ++i) {
          const SamplePoint p = scrambled_sobol(i, seed);
          boxes.emplace(static_cast<int>(std::ldexp(p.x, static_cast<int>(a))),
                        static_cast<int>(std::ldexp(p.y, static_cast<int>(m - a))));
        }
        ASSERT_EQ(boxes.size(), 1u << m) << "seed " << seed << ", m " << m << ", a " << a;
      }
    }
  }
}

TEST(SobolSampler, StaysInTheUnitSquare) {
  for (std::uint32_t i = 0; i < 10000; ++i) {
    const SamplePoint p = SobolSampler(3, i, i).pair(i);
    ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1) << i;
  }
}

/// Pairs of dimensions and pixels must not depend on each other: of the boxes that two numbers fall into,
/// each is as full as chance makes it. Chi-squared with 63 degrees of freedom is above 120 once in 10^5.
void expect_independent(const std::vector<std::pair<double, double>>& numbers) {
  std::vector<double> counts(64);
  for (const auto& [x, y] : numbers)
    counts[static_cast<std::size_t>(x * 8) * 8 + static_cast<std::size_t>(y * 8)] += 1;
  const double expected = static_cast<double>(numbers.size()) / 64;
  double chi2 = 0;
  for (double count : counts) chi2 += (count - expected) * (count - expected) / expected;
  EXPECT_LT(chi2, 120);
}

TEST(SobolSampler, PairsOfDimensionsAreIndependent) {
  for (std::uint32_t d = 1; d < 20; ++d) {
    std::vector<std::pair<double, double>> numbers;
    for (std::uint32_t i = 0; i < 4096; ++i) {
      const SobolSampler sampler(1, 17, i);
      numbers.emplace_back(sampler.number(0), sampler.number(d));
    }
    expect_independent(numbers);
  }
}

TEST(SobolSampler, PixelsAndSeedsAreIndependent) {
  std::vector<std::pair<double, double>> neighbours, seeds;
  for (std::uint32_t pixel = 0; pixel < 4096; ++pixel) {
    const double here = SobolSampler(1, pixel, 0).number(0);
    neighbours.emplace_back(here, SobolSampler(1, pixel + 1, 0).number(0));
    seeds.emplace_back(here, SobolSampler(2, pixel, 0).number(0));
  }
  expect_independent(neighbours);
  expect_independent(seeds);
}

}  // namespace
}  // namespace stbvh::harness
