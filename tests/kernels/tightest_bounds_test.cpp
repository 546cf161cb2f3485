#include "builder/tightest_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "test_meshes.h"

namespace stbvh {
namespace {

std::vector<BoundsSample> random_samples(test::Random& random, std::size_t count) {
  std::vector<BoundsSample> samples;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f lower = random.point(1.0f);
    const Vec3f size{random.unit(), random.unit(), random.unit()};
    samples.push_back({static_cast<float>(i) / static_cast<float>(count - 1),
                       {F32x4(lower), F32x4(lower.x + size.x, lower.y + size.y, lower.z + size.z)}});
  }
  return samples;
}

void expect_contains(const LinearBounds& bounds, const std::vector<BoundsSample>& samples) {
  for (const BoundsSample& s : samples) {
    for (int axis = 0; axis < 3; ++axis) {
      const float lower = (1 - s.parameter) * bounds.begin.lower[axis] + s.parameter * bounds.end.lower[axis];
      const float upper = (1 - s.parameter) * bounds.begin.upper[axis] + s.parameter * bounds.end.upper[axis];
      EXPECT_LE(lower, s.box.lower[axis] + 1e-5f);
      EXPECT_GE(upper, s.box.upper[axis] - 1e-5f);
    }
  }
}

TEST(TightestBounds, TheyContainEverySample) {
  test::Random random(1);
  for (std::size_t count = 2; count <= kMaxSteps + 2; count += count < 20 ? 1 : 37) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      const std::vector<BoundsSample> samples = random_samples(random, count);
      expect_contains(tightest_at_centre(samples), samples);
    }
  }
}

/// Steps an ulp apart have one parameter, which is rounded; none of them may be left out.
TEST(TightestBounds, SeveralSamplesAtOneTime) {
  test::Random random(3);
  for (std::size_t count = 3; count <= 40; ++count) {
    for (int repeat = 0; repeat < 50; ++repeat) {
      std::vector<BoundsSample> samples = random_samples(random, count);
      for (std::size_t i = 1; i < count; ++i) {
        if (random.bits() % 2 == 0) samples[i].parameter = samples[i - 1].parameter;
      }
      samples.back().parameter = 1.0f;
      expect_contains(tightest_at_centre(samples), samples);
    }
  }
}

/// What the paper's reference does: the line through the first and the last sample, moved outwards by the
/// worst violation of a sample between them.
LinearBounds shifted_chord(std::span<const BoundsSample> samples) {
  const BoundsSample& first = samples.front();
  const BoundsSample& last = samples.back();
  F32x4 below(0.0f);
  F32x4 above(0.0f);
  for (const BoundsSample& sample : samples) {
    const F32x4 s(sample.parameter);
    const F32x4 r(1.0f - sample.parameter);
    below = max(below, r * first.box.lower + s * last.box.lower - sample.box.lower);
    above = max(above, sample.box.upper - (r * first.box.upper + s * last.box.upper));
  }
  return {{first.box.lower - below, first.box.upper + above},
          {last.box.lower - below, last.box.upper + above}};
}

TEST(TightestBounds, NeverLooserAtTheCentreThanTheShiftedChord) {
  test::Random random(2);
  double chord = 0, hull = 0;
  for (int repeat = 0; repeat < 200; ++repeat) {
    const std::vector<BoundsSample> samples = random_samples(random, 9);
    const float c = shifted_chord(samples).centre_area();
    const float h = tightest_at_centre(samples).centre_area();
    EXPECT_LE(h, c * 1.0001f);
    chord += c;
    hull += h;
  }
  EXPECT_LT(hull, 0.95 * chord);
}

TEST(TightestBounds, HullOnPaper) {
  // A lower face at 0, -1, 0 over parameters 0, 0.5, 1: the lowest line through the centre lies at -1 there.
  std::vector<BoundsSample> samples;
  for (const auto& [s, v] : {std::pair{0.0f, 0.0f}, {0.5f, -1.0f}, {1.0f, 0.0f}}) {
    samples.push_back({s, {F32x4(v), F32x4(5.0f)}});
  }
  const LinearBounds bounds = tightest_at_centre(samples);
  EXPECT_FLOAT_EQ(0.5f * (bounds.begin.lower[0] + bounds.end.lower[0]), -1.0f);
  EXPECT_LE(bounds.begin.lower[0], 0.0f);
  EXPECT_LE(bounds.end.lower[0], 0.0f);
  EXPECT_FLOAT_EQ(bounds.begin.upper[0], 5.0f);
}

}  // namespace
}  // namespace stbvh
