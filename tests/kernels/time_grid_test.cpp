#include "layout/time_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "builder/build_mesh.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

TimeGrid grid(float begin, float end, int segments) {
  return {begin, end, end - begin, static_cast<float>(segments)};
}

TEST(TimeGrid, SegmentsOfTheUnitInterval) {
  const TimeGrid g = grid(0, 1, 4);
  EXPECT_EQ(segment_at(g, 0.0f).segment, 0u);
  EXPECT_EQ(segment_at(g, 0.25f).segment, 1u);
  EXPECT_EQ(segment_at(g, std::nextafter(0.25f, 0.0f)).segment, 0u);
  EXPECT_EQ(segment_at(g, 1.0f).segment, 3u);
  EXPECT_EQ(segment_at(g, 1.0f).fraction, 1.0f);
  EXPECT_EQ(segment_at(g, 0.625f).fraction, 0.5f);
}

TEST(TimeGrid, EndsOfAnyRangeStayInside) {
  for (const auto& [begin, end] : {std::pair{0.1f, 0.9f}, {0.3f, 0.30001f}, {-2.0f, 3.0f}, {1e-3f, 0.7f}}) {
    for (int segments = 1; segments <= 128; ++segments) {
      const TimeGrid g = grid(begin, end, segments);
      EXPECT_EQ(segment_at(g, begin).segment, 0u);
      EXPECT_EQ(segment_at(g, begin).fraction, 0.0f);
      EXPECT_EQ(segment_at(g, end).segment, static_cast<std::uint32_t>(segments - 1));
      EXPECT_EQ(segment_at(g, end).fraction, 1.0f);
    }
  }
}

/// Looked for from any segment that has begun, at step times, beside them and between.
TEST(TimeGrid, SegmentsOfUnevenSteps) {
  test::Random random(9);
  for (const std::size_t steps : {3u, 4u, 9u, 130u, 4096u}) {
    const std::vector<float> times =
        test::uneven_times(steps, static_cast<std::uint32_t>(steps), -0.25f, 1.5f);
    const auto last = static_cast<std::uint32_t>(steps - 2);
    for (int i = 0; i < test::count(2000); ++i) {
      float time = random.between(times.front(), times.back());
      if (i % 2 == 0) time = times[random.bits() % steps];
      if (i % 4 == 0) time = std::nextafter(time, i % 8 == 0 ? 2.0f : -2.0f);
      time = std::clamp(time, times.front(), times.back());
      std::uint32_t expected = 0;
      while (expected < last && times[expected + 1] <= time) ++expected;
      const std::uint32_t firsts[] = {0, expected,
                                      static_cast<std::uint32_t>(random.bits()) % (expected + 1)};
      for (const std::uint32_t first : firsts) {
        const SegmentTime at = segment_among(times.data(), first, last, time);
        ASSERT_EQ(at.segment, expected) << steps << " steps, from " << first << ", time " << time;
        ASSERT_GE(at.fraction, 0.0f);
        ASSERT_LE(at.fraction, 1.0f);
        const double exact =
            (double{time} - times[expected]) / (double{times[expected + 1]} - times[expected]);
        ASSERT_NEAR(at.fraction, exact, 0x1p-22);
      }
    }
    EXPECT_EQ(segment_among(times.data(), 0, last, times.back()).fraction, 1.0f);
  }
}

TEST(TimeGrid, FirstTimeOfSegmentIsTheExactBoundaryOfTheFloatEvaluation) {
  for (const auto& [begin, end] : {std::pair{0.0f, 1.0f}, {0.1f, 0.9f}, {-0.5f, 1.7f}, {0.25f, 0.2501f}}) {
    for (const int segments : {2, 3, 5, 7, 13, 16, 128}) {
      const TimeGrid g = grid(begin, end, segments);
      for (int k = 1; k < segments; ++k) {
        const float t = first_time_of_segment(g, static_cast<std::uint32_t>(k));
        EXPECT_GE(segment_at(g, t).segment, static_cast<std::uint32_t>(k));
        EXPECT_LT(segment_at(g, std::nextafter(t, -10.0f)).segment, static_cast<std::uint32_t>(k));
      }
    }
  }
}

}  // namespace
}  // namespace stbvh
