/// Scenes with another number of steps move as before.
#include "harness/scenes/resampled.h"

#include <gtest/gtest.h>

#include <cmath>

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
