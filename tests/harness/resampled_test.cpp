/// Scenes with another number of steps move as before.
#include "harness/scenes/resampled.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "harness/scenes/frozen_scene.h"
#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {
namespace {

Mesh moving(std::size_t steps) {
  Mesh mesh;
  mesh.indices = {0, 1, 2};
  for (std::size_t i = 0; i < steps; ++i) {
    VertexBuffer step(3);
    for (std::size_t v = 0; v < 3; ++v) {
      const auto x = static_cast<float>(v), t = static_cast<float>(i);
      step[v] = {std::sin(1.3f * t) + x, 0.7f * t * t, x};
    }
    mesh.steps.push_back(std::move(step));
  }
  return mesh;
}

TEST(Resampled, OldStepsAreAmongTheNewOnes) {
  Scene scene;
  for (const std::size_t steps : {1u, 2u, 3u, 5u, 9u}) scene.meshes.push_back(moving(steps));
  scene.meshes[3].time_range = {0.25f, 0.75f};
  const Scene fine = resampled(scene, 17);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh &old = scene.meshes[m], &now = fine.meshes[m];
    ASSERT_EQ(now.steps.size(), 17u);
    EXPECT_EQ(now.time_range.begin, old.time_range.begin);
    for (std::size_t i = 0; i < 17; ++i) {
      const std::size_t segments = old.segment_count();
      const Vec3f p = now.steps[i][2];
      if (i * segments % 16 == 0) {
        EXPECT_EQ(p.x, old.steps[i * segments / 16][2].x);
        EXPECT_EQ(p.y, old.steps[i * segments / 16][2].y);
        continue;
      }
      const std::size_t k = i * segments / 16;
      const double f = static_cast<double>(i * segments) / 16 - static_cast<double>(k);
      EXPECT_NEAR(p.x, (1 - f) * old.steps[k][2].x + f * old.steps[k + 1][2].x, 1e-6);
    }
  }
}

TEST(Resampled, FewerStepsCutCorners) {
  Scene scene;
  scene.meshes.push_back(moving(9));
  const Scene coarse = resampled(scene, 2);
  ASSERT_EQ(coarse.meshes[0].steps.size(), 2u);
  EXPECT_EQ(coarse.meshes[0].steps[0][1].x, scene.meshes[0].steps[0][1].x);
  EXPECT_EQ(coarse.meshes[0].steps[1][1].x, scene.meshes[0].steps[8][1].x);
}

Mesh uneven() {
  Mesh mesh = moving(4);
  mesh.step_times = {0.125f, 0.25f, 0.5f, 0.875f};
  mesh.time_range = {7, 8};  // not looked at
  return mesh;
}

TEST(Resampled, StepsAtTimesOfTheirOwnBecomeEquidistant) {
  Scene scene;
  scene.meshes.push_back(uneven());
  const Scene fine = resampled(scene, 7);  // an eighth apart
  const Mesh &old = scene.meshes[0], &now = fine.meshes[0];
  EXPECT_FALSE(now.has_step_times());
  EXPECT_EQ(now.time_range.begin, 0.125f);
  EXPECT_EQ(now.time_range.end, 0.875f);
  ASSERT_EQ(now.steps.size(), 7u);
  EXPECT_EQ(now.steps[0][2].y, old.steps[0][2].y);
  EXPECT_EQ(now.steps[1][2].y, old.steps[1][2].y);
  EXPECT_NEAR(now.steps[2][2].y, 0.5 * (old.steps[1][2].y + old.steps[2][2].y), 1e-6);
  EXPECT_EQ(now.steps[3][2].y, old.steps[2][2].y);
  EXPECT_NEAR(now.steps[5][2].y, (old.steps[2][2].y + 2 * old.steps[3][2].y) / 3, 1e-6);
  EXPECT_EQ(now.steps[6][2].y, old.steps[3][2].y);
}

TEST(Resampled, UnevenStepsFollowTheMotion) {
  Scene scene;
  scene.meshes = {moving(9), uneven(), moving(1)};
  const Scene fine = resampled(scene, 1000, StepPlaces::kUneven);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh &old = scene.meshes[m], &now = fine.meshes[m];
    ASSERT_EQ(now.steps.size(), 1000u);
    ASSERT_EQ(now.step_times.size(), 1000u);
    EXPECT_EQ(now.motion_range().begin, m == 1 ? 0.125f : 0.0f);
    EXPECT_EQ(now.motion_range().end, m == 1 ? 0.875f : 1.0f);
    double shortest = 1, longest = 0;
    for (std::size_t i = 0; i < 1000; ++i) {
      const float time = now.step_times[i];
      const Vec3 p = position_at(old, 2, motion_sample(old, time));
      EXPECT_NEAR(now.steps[i][2].y, p.y, 1e-6 * (1 + std::abs(p.y)));
      if (i == 0) continue;
      shortest = std::min(shortest, now.step_time(i) - now.step_time(i - 1));
      longest = std::max(longest, now.step_time(i) - now.step_time(i - 1));
    }
    EXPECT_GT(shortest, 0);
    EXPECT_GT(longest, 3 * shortest);
  }
}

TEST(Resampled, NoMoreUnevenStepsThanThereAreFloats) {
  Scene scene;
  scene.meshes.push_back(moving(3));
  scene.meshes[0].time_range = {0.5f, 0.5f + 0x1p-18f};
  const Mesh now = resampled(scene, 1000, StepPlaces::kUneven).meshes[0];
  EXPECT_LE(now.steps.size(), 65u);
  EXPECT_GT(now.steps.size(), 10u);
  EXPECT_EQ(now.steps.size(), now.step_times.size());
  EXPECT_TRUE(std::is_sorted(now.step_times.begin(), now.step_times.end(), std::less_equal<>()));
}

TEST(Frozen, IsWhatStepsAtTimesOfTheirOwnShow) {
  Scene scene;
  scene.meshes.push_back(uneven());
  EXPECT_TRUE(frozen(scene, 0.1f).meshes.empty());
  EXPECT_TRUE(frozen(scene, 0.9f).meshes.empty());
  const std::vector<VertexBuffer>& steps = scene.meshes[0].steps;
  const Mesh still = frozen(scene, 0.3125f).meshes.at(0);
  ASSERT_TRUE(still.is_static());
  EXPECT_FALSE(still.has_step_times());
  EXPECT_NEAR(still.steps[0][2].y, 0.75 * steps[1][2].y + 0.25 * steps[2][2].y, 1e-6);
  EXPECT_EQ(frozen(scene, 0.875f).meshes.at(0).steps[0][2].y, steps[3][2].y);
}

/// A time range is not looked at where nothing moves; with several steps it is.
TEST(Resampled, WhatStandsStillIsThereAllTheTime) {
  Scene scene;
  scene.meshes.push_back(moving(1));
  scene.meshes[0].time_range = {5.0f, 4.0f};
  const Scene fine = resampled(scene, 3);
  EXPECT_EQ(fine.meshes[0].time_range.begin, 0.0f);
  EXPECT_EQ(fine.meshes[0].time_range.end, 1.0f);
}

}  // namespace
}  // namespace stbvh::harness
