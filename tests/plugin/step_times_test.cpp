// Steps at times of their own, more of them than Embree takes, and steps that say nothing.
#include <cmath>
#include <utility>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

/// A triangle in the plane z = height of each of `steps` steps.
TestMesh lift(const std::vector<float>& heights) {
  TestMesh mesh = flat_triangle(0, static_cast<unsigned>(heights.size()));
  for (std::size_t step = 0; step < heights.size(); ++step) {
    for (Position& p : mesh.steps[step]) p.z = heights[step];
  }
  return mesh;
}

class PluginStepTimes : public ::testing::Test {
 protected:
  void commit(TestMesh mesh, const std::vector<float>& times) {
    mesh_ = std::move(mesh);
    std::vector<const void*> pointers;
    StbvhMeshArguments arguments = arguments_of(mesh_, pointers);
    arguments.stepTimes = times.empty() ? nullptr : times.data();
    arguments.geomID = 0;
    ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE)
        << stbvhGetErrorMessage(geometry_.get());
    ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE) << stbvhGetErrorMessage(geometry_.get());
    rtcAttachGeometry(scene_.get(), stbvhGetGeometry(geometry_.get()));
    rtcCommitScene(scene_.get());
  }

  /// The height at which a ray from above meets the triangle; NaN where it does not.
  float height(float time) const {
    const RTCRayHit hit = intersect(scene_.get(), ray_down(-.1f, -.1f, time));
    return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? NAN : hit.ray.org_z - hit.ray.tfar;
  }

  StbvhStatistics statistics() const {
    StbvhStatistics s;
    stbvhInitStatistics(&s);
    EXPECT_EQ(stbvhGetStatistics(geometry_.get(), &s), RTC_ERROR_NONE);
    return s;
  }

  TestMesh mesh_;
  Device device_ = new_device();
  Scene scene_ = new_scene(device_);
  OwnGeometry geometry_{stbvhNewGeometry(device_.get())};
};

TEST_F(PluginStepTimes, AreWhereTheMeshIs) {
  const std::vector<float> times{0, .1f, .9f, .95f, 1}, heights{0, 1, -1, 1, 0};
  commit(lift(heights), times);
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    for (const float f : {0.0f, .25f, .5f, 1.0f}) {
      const float time = times[i] + f * (times[i + 1] - times[i]);
      EXPECT_NEAR(height(time), heights[i] + f * (heights[i + 1] - heights[i]), 1e-4f) << time;
    }
  }
  EXPECT_EQ(statistics().stepsKept, 5u);
}

TEST_F(PluginStepTimes, OutsideOfThemNothingIsHit) {
  commit(lift({0, 1, 0}), {.25f, .3f, .75f});
  EXPECT_TRUE(std::isnan(height(.2f)));
  EXPECT_NEAR(height(.3f), 1.0f, 1e-4f);
  EXPECT_TRUE(std::isnan(height(.8f)));
}

TEST_F(PluginStepTimes, AreAsManyAsAUserHas) {
  std::vector<float> times, heights;
  for (unsigned i = 0; i < STBVH_MAX_STEP_COUNT; ++i) {
    const float x = static_cast<float>(i) / (STBVH_MAX_STEP_COUNT - 1);
    times.push_back(x * x);
    heights.push_back(std::sin(40 * x * x));
  }
  commit(lift(heights), times);
  for (unsigned i = 0; i < STBVH_MAX_STEP_COUNT; i += 7)
    EXPECT_NEAR(height(times[i]), heights[i], 1e-3f) << i;
  EXPECT_EQ(statistics().stepsGiven, std::size_t{STBVH_MAX_STEP_COUNT});
}

TEST_F(PluginStepTimes, StepsThatSayNothingAreLeftOut) {
  commit(lift({0, 0, 0, 0, 0, 0, 0, 0, 0}), {});
  EXPECT_EQ(statistics().stepsGiven, 9u);
  EXPECT_EQ(statistics().stepsKept, 1u);
  EXPECT_EQ(height(.3f), 0.0f);
}

TEST_F(PluginStepTimes, AToleranceLeavesOutMore) {
  const std::vector<float> heights{0, .3f, .5f, .8f, 1, .8f, .5f, .2f, 0};
  ASSERT_EQ(stbvhSetGeometryTolerance(geometry_.get(), .06f), RTC_ERROR_NONE);
  commit(lift(heights), {});
  EXPECT_EQ(statistics().stepsKept, 3u);
  EXPECT_NEAR(statistics().maxDeviation, .05, 1e-6);
  for (unsigned i = 0; i < 9; ++i) EXPECT_NEAR(height(static_cast<float>(i) / 8), heights[i], .0601f);
  EXPECT_NEAR(height(.5f), 1.0f, 1e-6f);
  ASSERT_EQ(stbvhSetGeometryTolerance(geometry_.get(), STBVH_KEEP_ALL_STEPS), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  EXPECT_EQ(statistics().stepsKept, 9u);
}

}  // namespace
}  // namespace stbvh::test
