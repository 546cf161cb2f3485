/// How many steps load_gltf() gives to motions of which it is known how many they need, and where a shutter
/// is longer than a clip.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "harness/scenes/vec3.h"
#include "tests/harness/gltf_files.h"

namespace stbvh::harness {
namespace {

class GltfStepsTest : public AnimatedGltfTest {
 protected:
  Scene load(const Document& d, const GltfOptions& options) {
    warnings.clear();
    return load_gltf(write("file.glb", d.bytes()), options,
                     [this](const std::string& sentence) { warnings.push_back(sentence); });
  }

  std::vector<std::size_t> step_counts(const Document& d, double share, std::optional<FilePart> shutter = {},
                                       ShutterMode mode = ShutterMode::kClamp) {
    GltfOptions options;
    options.largest_deviation = share;
    options.shutter = shutter;
    options.shutter_mode = mode;
    std::vector<std::size_t> counts;
    for (const Mesh& mesh : load(d, options).meshes) counts.push_back(mesh.steps.size());
    return counts;
  }

  std::vector<std::string> warnings;
};

using Counts = std::vector<std::size_t>;

TEST_F(GltfStepsTest, ConstantVelocityNeedsTwo) {
  EXPECT_EQ(step_counts(sliding({0, 3}, {0, 10}), 1e-5), Counts{2});
  EXPECT_EQ(step_counts(sliding({0, 1, 3}, {0, 2, 6}), 1e-5), Counts{2});  // the key changes nothing
  EXPECT_TRUE(warnings.empty());
}

TEST_F(GltfStepsTest, WhatMovesLessThanTheToleranceNeedsOne) {
  EXPECT_EQ(step_counts(Document(), 1e-6), Counts{1});
  // The square's diagonal is about 1.414; it moves by 0.01.
  const Document d = sliding({0, 1}, {0, 0.01f});
  EXPECT_EQ(step_counts(d, 0.0075), Counts{1});
  EXPECT_EQ(step_counts(d, 0.0065), Counts{2});
}

/// Farthest that an arc of `angle` and the polygon of n chords of equal length in it get from each other.
double sagitta(double radius, double angle, std::size_t n) {
  return radius * (1 - std::cos(angle / (2 * static_cast<double>(n))));
}

/// Of the bounds of the square from (0, 0) to (1, 1) as it turns by 90 degrees about the origin.
const double kSweptDiagonal = std::sqrt(2.0 * 2.0 + 2.0);

TEST_F(GltfStepsTest, RotationsNeedWhatTheSagittaSays) {
  Document d;
  turn_by_90_degrees(d, 0);
  const double radius = std::sqrt(2.0);
  for (const std::size_t segments : {1u, 2u, 3u, 4u, 7u, 16u, 33u, 64u, 127u}) {
    const double enough = sagitta(radius, kPi / 2, segments);
    const double too_little = segments > 1 ? sagitta(radius, kPi / 2, segments - 1) : 3 * enough;
    const double between = 0.5 * (enough + too_little) / kSweptDiagonal;
    EXPECT_EQ(step_counts(d, between), Counts{segments + 1}) << segments;
    EXPECT_TRUE(warnings.empty());
  }
}

TEST_F(GltfStepsTest, TheWarningSaysHowFarTheMostStepsStay) {
  Document d;
  turn_by_90_degrees(d, 0);
  EXPECT_EQ(step_counts(d, 5e-6), Counts{kMaxSceneSteps});
  ASSERT_EQ(warnings.size(), 1u);
  const double left = sagitta(std::sqrt(2.0), kPi / 2, kMaxSceneSteps - 1) / kSweptDiagonal;
  EXPECT_NE(warnings[0].find("1 of 1 meshes stay further than 5e-06"), std::string::npos) << warnings[0];
  EXPECT_NEAR(std::stod(warnings[0].substr(warnings[0].rfind(' ') + 1)), left, 0.1 * left) << warnings[0];
}

TEST_F(GltfStepsTest, CornersOfThePathWantAStepThere) {
  // At 3 and 5 of 10 seconds: the least number of equal parts that has both is 10.
  EXPECT_EQ(step_counts(sliding({0, 3, 5, 10}, {0, 10, 2, 9}), 1e-5), Counts{11});
  EXPECT_EQ(step_counts(sliding({0, 5, 10}, {0, 10, 2}), 1e-5), Counts{3});
  EXPECT_TRUE(warnings.empty());
}

TEST_F(GltfStepsTest, JumpsAreBeyondAnyNumberOfSteps) {
  EXPECT_EQ(step_counts(sliding({0, 0.4f, 1}, {0, 1, 1}, "STEP"), 1e-3), Counts{kMaxSceneSteps});
  EXPECT_EQ(warnings.size(), 1u);
  // A blip that is over between any two equidistant looks.
  EXPECT_EQ(step_counts(sliding({0, 0.44151f, 0.44152f, 0.44153f, 1}, {0, 0, 1, 0, 0}), 1e-2),
            Counts{kMaxSceneSteps});
  EXPECT_EQ(warnings.size(), 1u);
}

TEST_F(GltfStepsTest, EachMeshHasItsOwnNumber) {
  Document d;
  d.root["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}, {{"mesh", 0}, {"translation", {0, 0, 50}}}};
  d.root["scenes"][0]["nodes"] = {0, 1, 2};
  turn_by_90_degrees(d, 0);
  animate_node(d, 1, "translation", {0, 1}, {0, 0, 0, 5, 0, 0});
  // Bounds: x from -1 to 6, y from 0 to 1.414, z from 0 to 50.
  const double diagonal = std::sqrt(49 + 2 + 2500.0);
  const double share = 1.1 * sagitta(std::sqrt(2.0), kPi / 2, 8) / diagonal;
  EXPECT_EQ(step_counts(d, share), (Counts{9, 2, 1}));
}

TEST_F(GltfStepsTest, ShuttersLongerThanTheClip) {
  const Document d = sliding({1, 2}, {0, 10});
  const auto x = [&](FilePart shutter, std::size_t steps, ShutterMode mode) {
    Floats places;
    const Scene scene = load(d, {"", shutter, steps, {}, mode});
    for (const VertexBuffer& step : scene.meshes.at(0).steps) places.push_back(step[0].x);
    return places;
  };
  EXPECT_EQ(x({1, 4}, 7, ShutterMode::kClamp), (Floats{0, 5, 10, 10, 10, 10, 10}));
  EXPECT_EQ(x({1, 4}, 7, ShutterMode::kLoop), (Floats{0, 5, 10, 5, 0, 5, 0}));
  EXPECT_EQ(x({0, 2}, 5, ShutterMode::kClamp), (Floats{0, 0, 0, 5, 10}));
  EXPECT_EQ(x({0, 2}, 5, ShutterMode::kLoop), (Floats{0, 5, 0, 5, 10}));
  EXPECT_EQ(x({1, 2}, 3, ShutterMode::kLoop), x({1, 2}, 3, ShutterMode::kClamp));
  expect_refused(write("file.glb", d.bytes()), "repeats a clip of 1 seconds more than 129 times",
                 {"", FilePart{0, 200}, 9, {}, ShutterMode::kLoop});
  EXPECT_EQ(refusal(write("file.glb", d.bytes()), {"", FilePart{0, 200}, 9, {}, ShutterMode::kClamp}), "");
}

TEST_F(GltfStepsTest, StepsOfLoopsAndOfWhatStopsAreChosenToo) {
  const Document d = sliding({0, 0.5f, 1}, {0, 10, 0});
  EXPECT_EQ(step_counts(d, 1e-5, FilePart{0, 2}, ShutterMode::kLoop), Counts{5});
  EXPECT_EQ(step_counts(d, 1e-5, FilePart{0, 2}, ShutterMode::kClamp), Counts{5});
  EXPECT_EQ(step_counts(d, 1e-5, FilePart{0, 4}, ShutterMode::kLoop), Counts{9});
  EXPECT_TRUE(warnings.empty());
  step_counts(sliding({0, 1}, {0, 10}), 1e-3, FilePart{0, 3}, ShutterMode::kLoop);
  EXPECT_EQ(warnings.size(), 1u);  // it jumps back
}

TEST_F(GltfStepsTest, DeviationsThatCannotBeAreRefused) {
  for (const double share : {0.0, -1.0, 1.0, std::numeric_limits<double>::quiet_NaN()}) {
    GltfOptions options;
    options.largest_deviation = share;
    expect_refused(write("file.glb", Document().bytes()), "must lie between 0 and 1", options);
  }
}

TEST(GltfSteps, OfOurOwnFilesStayWithinTheTolerance) {
  // Against 129 steps, which stand for the true motion.
  for (const char* name : {"bending_tube", "morphing_sphere", "quantised_flag"}) {
    const fs::path file = kData / (std::string(name) + ".glb");
    GltfOptions exact, adaptive;
    exact.steps = kMaxSceneSteps;
    adaptive.largest_deviation = 2e-3;
    const Scene truth = load_gltf(file, exact), few = load_gltf(file, adaptive);
    const Box3f box = truth.bounds();
    const double diagonal =
        std::hypot(box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z);
    double worst = 0;
    for (std::size_t m = 0; m < truth.meshes.size(); ++m) {
      const std::vector<VertexBuffer>& steps = few.meshes[m].steps;
      EXPECT_LT(steps.size(), kMaxSceneSteps) << name;
      for (std::size_t s = 0; s < truth.meshes[m].steps.size(); ++s) {
        const double along = static_cast<double>(s * (steps.size() - 1)) / (kMaxSceneSteps - 1);
        const auto i = static_cast<std::size_t>(along);
        const double f = along - std::floor(along);
        const VertexBuffer &a = steps[i], &b = steps[std::min(i + 1, steps.size() - 1)];
        const VertexBuffer& p = truth.meshes[m].steps[s];
        for (std::size_t v = 0; v < p.size(); ++v) {
          worst =
              std::max(worst, std::hypot(lerp(a[v].x, b[v].x, f) - p[v].x, lerp(a[v].y, b[v].y, f) - p[v].y,
                                         lerp(a[v].z, b[v].z, f) - p[v].z));
        }
      }
    }
    EXPECT_LT(worst, 2.02e-3 * diagonal) << name;
    EXPECT_GT(worst, 0) << name;
  }
}

TEST(GltfSteps, OfTheMastTheHubAndTheBladesThatJump) {
  GltfOptions adaptive;
  adaptive.largest_deviation = 2e-3;
  std::vector<std::string> warnings;
  const Scene scene = load_gltf(kData / "propeller.glb", adaptive,
                                [&](const std::string& sentence) { warnings.push_back(sentence); });
  ASSERT_EQ(scene.meshes.size(), 5u);
  EXPECT_EQ(scene.meshes[0].steps.size(), 1u);
  EXPECT_GT(scene.meshes[1].steps.size(), 2u);
  EXPECT_LT(scene.meshes[1].steps.size(), kMaxSceneSteps);
  for (std::size_t blade = 2; blade < 5; ++blade) EXPECT_EQ(scene.meshes[blade].steps.size(), kMaxSceneSteps);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("propeller.glb: 3 of 5 meshes"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace stbvh::harness
