// The common grid of several meshes: its interpolated boxes hold every mesh at every time.
#include "plugin/motion_grid.h"

#include <algorithm>
#include <cmath>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

using plugin::fit_motion_grid;
using plugin::MeshMotion;
using plugin::MotionGrid;

/// Interpolated as the kernels and Embree do it: in float.
Box3f box_at(const std::vector<Box3f>& steps, TimeRange range, float time) {
  if (steps.size() == 1) return steps[0];
  const std::size_t segments = steps.size() - 1;
  const float u = (time - range.begin) / (range.end - range.begin) * static_cast<float>(segments);
  const auto k = std::min(static_cast<std::size_t>(std::max(0.0f, std::floor(u))), segments - 1);
  const float f = u - static_cast<float>(k);
  const auto lerp = [f](float a, float b) { return (1 - f) * a + f * b; };
  const Box3f &a = steps[k], &b = steps[k + 1];
  return {{lerp(a.lower.x, b.lower.x), lerp(a.lower.y, b.lower.y), lerp(a.lower.z, b.lower.z)},
          {lerp(a.upper.x, b.upper.x), lerp(a.upper.y, b.upper.y), lerp(a.upper.z, b.upper.z)}};
}

bool contains(const Box3f& a, const Box3f& b) {
  return a.lower.x <= b.lower.x && a.lower.y <= b.lower.y && a.lower.z <= b.lower.z &&
         a.upper.x >= b.upper.x && a.upper.y >= b.upper.y && a.upper.z >= b.upper.z;
}

MeshMotion random_motion(Random& random, float scale) {
  MeshMotion motion;
  const unsigned step_counts[] = {1, 2, 3, 6, 9, 15, 128, 129};
  motion.steps.resize(step_counts[random.below(8)]);
  motion.time_range.begin = random.below(3) == 0 ? random.between(-1, .9f) : 0;
  motion.time_range.end = random.below(3) == 0 ? motion.time_range.begin + random.between(.01f, 2) : 1;
  if (motion.time_range.end <= motion.time_range.begin) motion.time_range.end = motion.time_range.begin + .5f;
  for (Box3f& box : motion.steps) {
    const Vec3f c{scale * random.between(-1, 1), scale * random.between(-1, 1),
                  scale * random.between(9, 10)};
    const float size = scale * random.unit();
    box = {c, {c.x + size, c.y + size, c.z}};
  }
  return motion;
}

TEST(PluginMotionGrid, ContainsEveryMeshAtEveryTime) {
  Random random(1);
  for (unsigned round = 0; round < 300; ++round) {
    const float scale = round % 3 == 0 ? 1e-6f : round % 3 == 1 ? 1.0f : 1e9f;
    std::vector<MeshMotion> motions;
    for (unsigned i = 0; i < 2 + round % 5; ++i) motions.push_back(random_motion(random, scale));
    const MotionGrid grid = fit_motion_grid(motions);
    ASSERT_GE(grid.steps.size(), 1u);
    ASSERT_LE(grid.steps.size(), kMaxSteps);
    for (unsigned i = 0; i < 1000; ++i) {
      const float time = i < 129 ? static_cast<float>(i) / 128 : random.unit();
      for (const MeshMotion& motion : motions) {
        const bool is_static = motion.steps.size() == 1;
        if (!is_static && (time < motion.time_range.begin || time > motion.time_range.end)) continue;
        ASSERT_TRUE(contains(box_at(grid.steps, grid.time_range, time),
                             box_at(motion.steps, motion.time_range, time)))
            << "round " << round << " time " << time;
        ASSERT_TRUE(grid.steps.size() == 1 || (grid.time_range.begin <= time && time <= grid.time_range.end));
      }
    }
  }
}

/// Steps at times of their own, any number of them: Embree is told equidistant ones, at most 129.
TEST(PluginMotionGrid, ContainsUnevenStepsAtEveryTime) {
  Random random(4);
  for (unsigned round = 0; round < 100; ++round) {
    std::vector<MeshMotion> motions;
    for (unsigned i = 0; i < 1 + round % 3; ++i) {
      MeshMotion motion = random_motion(random, 1);
      const std::size_t steps = round % 10 == 0 ? 1000 : 2 + random.below(30);
      motion.steps.resize(steps, motion.steps[0]);
      std::vector<float> times(steps);
      for (float& time : times) time = random.unit();
      if (round % 4 == 0) times[1] = std::nextafter(times[0], 2.0f);
      std::sort(times.begin(), times.end());
      if (std::adjacent_find(times.begin(), times.end()) != times.end()) continue;
      for (Box3f& box : motion.steps) {
        const float x = random.between(-1, 1);
        box = {{x, -x, x}, {x + .1f, .1f - x, x}};
      }
      motion.time_range = {times.front(), times.back()};
      motion.step_times = times;
      motions.push_back(motion);
    }
    const MotionGrid grid = fit_motion_grid(motions);
    ASSERT_LE(grid.steps.size(), 129u);
    for (const MeshMotion& motion : motions) {
      for (std::size_t i = 0; i + 1 < motion.steps.size(); ++i) {
        for (const float f : {0.0f, 0.25f, 1.0f}) {
          const float begin = motion.step_times[i], end = motion.step_times[i + 1];
          const float time = std::clamp(begin + f * (end - begin), begin, end);
          const float exact = (time - begin) / (end - begin);
          const Box3f box = box_at({motion.steps[i], motion.steps[i + 1]}, {0, 1}, exact);
          ASSERT_TRUE(contains(box_at(grid.steps, grid.time_range, time), box))
              << "round " << round << " time " << time;
        }
      }
    }
  }
}

TEST(PluginMotionGrid, OfOneMeshIsItsOwn) {
  Random random(2);
  MeshMotion motion = random_motion(random, 1);
  motion.steps.resize(6, motion.steps[0]);
  motion.time_range = {.2f, .7f};
  const std::vector<MeshMotion> motions{
      motion, {{Box3f::empty()}, {0, 1}}, {{motion.steps[0], motion.steps[0]}, {3, 4}}};
  const MotionGrid grid = fit_motion_grid(motions);
  ASSERT_EQ(grid.steps.size(), 6u);
  EXPECT_EQ(grid.time_range.begin, .2f);
  EXPECT_EQ(grid.time_range.end, .7f);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(grid.steps[i].lower.x, motion.steps[i].lower.x);
}

TEST(PluginMotionGrid, OfMeshesWithTheSameStepsKeepsThemTight) {
  Random random(3);
  std::vector<MeshMotion> motions(2);
  for (MeshMotion& motion : motions) {
    for (unsigned step = 0; step < 9; ++step) {
      const float x = random.between(-1, 1);
      motion.steps.push_back({{x, x, x}, {x + 1, x + 1, x + 1}});
    }
  }
  const MotionGrid grid = fit_motion_grid(motions);
  ASSERT_EQ(grid.steps.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) {
    const float lower = std::min(motions[0].steps[i].lower.x, motions[1].steps[i].lower.x);
    EXPECT_NEAR(grid.steps[i].lower.x, lower, 1e-4f);
  }
}

TEST(PluginMotionGrid, OfNothingIsOneEmptyBox) {
  const std::vector<std::vector<MeshMotion>> nothings{
      {}, {{{Box3f::empty()}, {0, 1}}}, {{{Box3f::empty(), Box3f::empty()}, {0, 1}}}};
  for (const auto& motions : nothings) {
    const MotionGrid grid = fit_motion_grid(motions);
    ASSERT_EQ(grid.steps.size(), 1u);
    EXPECT_GT(grid.steps[0].lower.x, grid.steps[0].upper.x);
  }
}

TEST(PluginMotionGrid, StaysWithinWhatEmbreeTakesForValid) {
  const float huge = 1.8e18f;
  const Box3f low{{-huge, -huge, -huge}, {-huge, -huge, -huge}}, high{{huge, huge, huge}, {huge, huge, huge}};
  const MotionGrid grid =
      fit_motion_grid(std::vector<MeshMotion>{{{low, high, low, high}, {0, 1}}, {{high, low, high}, {0, 1}}});
  for (const Box3f& box : grid.steps) {
    EXPECT_GT(box.lower.x, -kMaxCoordinate);
    EXPECT_LT(box.upper.x, kMaxCoordinate);
    EXPECT_LE(box.lower.x, box.upper.x);
  }
}

}  // namespace
}  // namespace stbvh::test
