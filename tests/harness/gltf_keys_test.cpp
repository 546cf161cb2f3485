/// Steps at the keys of a file: where load_gltf() has them, and that what moves between them is where the
/// animation has it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/vec3.h"
#include "tests/harness/gltf_files.h"

namespace stbvh::harness {
namespace {

float before(float time) {
  return std::nextafter(time, -1.0f);
}

double diagonal_of(const Scene& scene) {
  const Box3f box = scene.bounds();
  return length(to_double(box.upper) - to_double(box.lower));
}

GltfOptions over(FilePart shutter, ShutterMode mode = ShutterMode::kClamp) {
  GltfOptions options;
  options.shutter = shutter;
  options.shutter_mode = mode;
  return options;
}

GltfOptions within(double share) {
  GltfOptions options;
  options.largest_deviation = share;
  return options;
}

class GltfKeysTest : public AnimatedGltfTest {
 protected:
  Mesh load(const Document& d, GltfOptions options = {}) {
    options.at_keys = true;
    warnings.clear();
    Scene scene = load_gltf(write("file.glb", d.bytes()), options,
                            [this](const std::string& sentence) { warnings.push_back(sentence); });
    return std::move(scene.meshes.at(0));
  }

  static Floats places(const Mesh& mesh) {
    Floats x;
    for (const VertexBuffer& step : mesh.steps) x.push_back(step[0].x);
    return x;
  }

  std::vector<std::string> warnings;
};

TEST_F(GltfKeysTest, StraightMotionHasThemAndNoMore) {
  const Mesh mesh = load(sliding({0, 1, 4, 5}, {0, 2, 7, 1}));
  EXPECT_EQ(mesh.step_times, (Floats{0, 0.2f, 0.8f, 1}));
  EXPECT_EQ(places(mesh), (Floats{0, 2, 7, 1}));
}

TEST_F(GltfKeysTest, AreEquidistantStepsWhereTheyAre) {
  const Mesh mesh = load(sliding({1, 2, 3}, {0, 2, 7}));
  EXPECT_FALSE(mesh.has_step_times());
  EXPECT_EQ(places(mesh), (Floats{0, 2, 7}));
  Floats times, x;  // thirtieths of a second, as floats
  for (int i = 0; i <= 60; ++i) {
    times.push_back(static_cast<float>(i) / 30);
    x.push_back(static_cast<float>(i % 7));
  }
  EXPECT_FALSE(load(sliding(times, x)).has_step_times());
  times[7] += 1e-4f;
  EXPECT_TRUE(load(sliding(times, x)).has_step_times());
}

TEST_F(GltfKeysTest, TheShutterCutsMotionsAtItsEnds) {
  const Mesh mesh = load(sliding({0, 1, 4}, {0, 2, 8}), over({0.5f, 3}));
  EXPECT_EQ(mesh.step_times, (Floats{0, 0.2f, 1}));
  EXPECT_EQ(places(mesh), (Floats{1, 2, 6}));
  const Mesh longer = load(sliding({1, 2}, {3, 5}), over({0, 4}));
  EXPECT_EQ(places(longer), (Floats{3, 3, 5, 5}));
  EXPECT_EQ(longer.step_times, (Floats{0, 0.25f, 0.5f, 1}));
}

TEST_F(GltfKeysTest, JumpsTakeOneFloat) {
  const Mesh mesh = load(sliding({0, 2, 5}, {0, 1, 4}, "STEP"));
  EXPECT_EQ(mesh.step_times, (Floats{0, before(0.4f), 0.4f, before(1), 1}));
  EXPECT_EQ(places(mesh), (Floats{0, 0, 1, 1, 4}));
  // Two keys at one time.
  const Mesh twice = load(sliding({0, 2, 2, 5}, {0, 1, 3, 4}));
  EXPECT_EQ(twice.step_times, (Floats{0, before(0.4f), 0.4f, 1}));
  EXPECT_EQ(places(twice), (Floats{0, 1, 3, 4}));
}

TEST_F(GltfKeysTest, AClipThatBeginsAgainJumpsBack) {
  const GltfOptions loop = over({0.5f, 2.5f}, ShutterMode::kLoop);
  const Mesh mesh = load(sliding({0, 1}, {0, 8}), loop);
  EXPECT_EQ(mesh.step_times, (Floats{0, before(0.25f), 0.25f, before(0.75f), 0.75f, 1}));
  EXPECT_EQ(places(mesh), (Floats{4, 8, 0, 8, 0, 4}));
  // One that ends as it begins does not; and one that stops is over only when all are.
  EXPECT_EQ(places(load(sliding({0, 0.5f, 1}, {0, 8, 0}), loop)), (Floats{8, 0, 8, 0, 8}));
  Document d = sliding({0, 0.5f}, {0, 8});
  d.root["nodes"].push_back({{"mesh", 0}});
  d.root["scenes"][0]["nodes"].push_back(1);
  animate_node(d, 1, "translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  EXPECT_EQ(places(load(d, loop)), (Floats{8, 8, 0, 8, 8, 0, 8}));
}

TEST_F(GltfKeysTest, AreThoseOfAllNodesAbove) {
  Document d;
  d.root["nodes"] = {{{"mesh", 0}}, {{"children", {0}}}, {{"mesh", 0}}};
  d.root["scenes"][0]["nodes"] = {1, 2};
  animate_node(d, 0, "translation", {0, 2, 10}, {0, 0, 0, 1, 0, 0, 1, 5, 0});
  animate_node(d, 1, "translation", {0, 7, 10}, {0, 0, 0, 3, 0, 0, 0, 0, 0});
  animate_node(d, 2, "translation", {0, 1, 10}, {0, 0, 0, 3, 0, 0, 0, 0, 0});  // of another
  EXPECT_EQ(load(d).step_times, (Floats{0, 0.2f, 0.7f, 1}));
}

TEST_F(GltfKeysTest, CurvesHaveAsFewMoreAsKeepThemWithinTheBound) {
  Document d;
  turn_by_90_degrees(d, 0);
  const double radius = std::sqrt(2.0), swept_diagonal = std::sqrt(2.0 * 2.0 + 2.0);
  const auto sagitta = [&](double n) { return radius * (1 - std::cos(kPi / 4 / n)); };
  for (const std::size_t n : {1u, 2u, 3u, 7u, 64u, 100u}) {
    const double share = 0.5 * (sagitta(double(n)) + (n > 1 ? sagitta(double(n - 1)) : 1.0)) / swept_diagonal;
    EXPECT_EQ(load(d, within(share)).steps.size(), n + 1);
    EXPECT_TRUE(warnings.empty());
  }
  const std::size_t by_default = load(d).steps.size();
  EXPECT_LE(sagitta(double(by_default - 1)), kKeyDeviation * swept_diagonal);
  EXPECT_GT(sagitta(double(by_default - 2)), kKeyDeviation * swept_diagonal);
}

TEST_F(GltfKeysTest, BetweenStraightOnesOnlyTheCurveHasMore) {
  const float half = std::sqrt(0.5f);
  Document d;
  animate_node(d, 0, "translation", {0, 1, 2, 4}, {0, 0, 0, 1, 0, 0, 1, 0, 0, 5, 0, 0});
  animate_node(d, 0, "rotation", {1, 2}, {0, 0, 0, 1, 0, 0, half, half});
  const Mesh mesh = load(d, within(1e-3));
  EXPECT_GT(mesh.steps.size(), 8u);
  EXPECT_EQ(mesh.step_times[1], 0.25f);
  EXPECT_EQ(mesh.step_times[mesh.steps.size() - 2], 0.5f);
}

TEST_F(GltfKeysTest, MoreThanAMeshCanHaveAreToldOf) {
  Floats times, x;
  for (int i = 0; i < 10000; ++i) {
    times.push_back(static_cast<float>(i) + (i % 3 == 0 ? 0.25f : 0.0f));
    x.push_back(static_cast<float>(i % 2));
  }
  const auto first = [](const Floats& all) { return Floats(all.begin(), all.begin() + 4096); };
  EXPECT_EQ(load(sliding(first(times), first(x))).steps.size(), kMaxSteps);
  EXPECT_TRUE(warnings.empty());
  const Mesh mesh = load(sliding(times, x));
  EXPECT_LE(mesh.steps.size(), kMaxSteps);
  EXPECT_GT(mesh.steps.size(), kMaxSteps / 4);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("1 of 1 meshes stay further than 1e-05"), std::string::npos) << warnings[0];
  // Half turns, of which each would need hundreds.
  Document d;
  Floats turns;
  for (int i = 0; i <= 20; ++i)
    turns.insert(turns.end(),
                 {0, 0, std::sin(1.5f * static_cast<float>(i)), std::cos(1.5f * static_cast<float>(i))});
  animate_node(d, 0, "rotation", Floats(times.begin(), times.begin() + 21), turns);
  const std::size_t steps = load(d, within(1e-6)).steps.size();
  EXPECT_LE(steps, kMaxSteps);
  EXPECT_GT(steps, kMaxSteps / 4);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("even with 4096 steps"), std::string::npos) << warnings[0];
}

TEST_F(GltfKeysTest, MayNotNeedMoreMemoryThanTheFileMay) {
  // A mesh of 400,000 vertices that stand nowhere in the file, and four thousand keys.
  Document d = sliding({0, 1}, {0, 1});
  d.root["accessors"].push_back({{"componentType", 5126}, {"count", 400000}, {"type", "VEC3"}});
  d.primitive()["attributes"]["POSITION"] = d.root["accessors"].size() - 1;
  Floats times, values;
  for (int i = 0; i < 4000; ++i) {
    times.push_back(static_cast<float>(i));
    values.insert(values.end(), {static_cast<float>(i % 2), 0, 0});
  }
  animate_node(d, 0, "translation", times, values);
  GltfOptions options;
  options.at_keys = true;
  expect_refused(write("file.glb", d.bytes()), "would need more memory", options);
}

TEST_F(GltfKeysTest, VerticesThatAreNowhereAreRefusedInTheEnd) {
  Document d = sliding({0, 1}, {0, 1});
  const float nan = std::nanf("");
  d.primitive()["attributes"]["POSITION"] = d.add<float>("VEC3", 5126, Floats(12, nan));
  GltfOptions options;
  options.at_keys = true;
  expect_refused(write("file.glb", d.bytes()), "none of its triangles can be shown", options);
}

/// Where all vertices are at random moments of a shutter, against scenes that are read at those moments
/// alone.
void expect_true_places(const fs::path& file, FilePart shutter, const std::string& clip = "") {
  GltfOptions keys = over(shutter);
  keys.clip = clip;
  keys.at_keys = true;
  const Scene moving = load_gltf(file, keys);
  const double diagonal = diagonal_of(moving);
  std::mt19937 random(1);
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    const double seconds = std::uniform_real_distribution(shutter.begin, shutter.end)(random);
    const auto time = static_cast<float>((seconds - shutter.begin) / (shutter.end - shutter.begin));
    GltfOptions instant = over({seconds, seconds});
    instant.steps = 1;
    instant.clip = clip;
    const Scene still = load_gltf(file, instant);
    ASSERT_EQ(still.meshes.size(), moving.meshes.size());
    for (std::size_t m = 0; m < still.meshes.size(); ++m) {
      const Mesh& mesh = moving.meshes[m];
      ASSERT_TRUE(is_visible_at(mesh, time));
      const MotionSample sample = motion_sample(mesh, time);
      for (std::uint32_t v = 0; v < mesh.steps[0].size(); ++v) {
        const Vec3 off = position_at(mesh, v, sample) - to_double(still.meshes[m].steps[0][v]);
        worst = std::max(worst, length(off));
      }
    }
  }
  // A time is a float: what moves by the diagonal in a hundredth of the shutter is off by 6e-6 of it.
  EXPECT_LT(worst, 2 * kKeyDeviation * diagonal);
}

TEST(GltfKeys, OwnFilesAreWhereTheAnimationHasThem) {
  for (const char* name : {"bending_tube", "morphing_sphere", "quantised_flag"}) {
    SCOPED_TRACE(name);
    expect_true_places(kData / (std::string(name) + ".glb"), {0.1f, 0.9f});
  }
}

TEST(GltfKeys, SharedAssetsAreWhereTheAnimationHasThem) {
  if (!fs::exists(kAssets / "InterpolationTest.glb")) GTEST_SKIP() << "no assets in " << kAssets;
  // Steps, lines and splines of scale, rotation and translation; then morph targets and skins. Past the ends
  // of their clips.
  for (int clip = 0; clip < 9; ++clip) {
    SCOPED_TRACE(clip);
    expect_true_places(kAssets / "InterpolationTest.glb", {0.1f, 2.3f}, std::to_string(clip));
  }
  for (const char* name : {"BoxAnimated", "AnimatedMorphSphere", "CesiumMan", "RobotExpressive"}) {
    SCOPED_TRACE(name);
    expect_true_places(kAssets / (std::string(name) + ".glb"), {0.1f, 2.3f});
  }
}

TEST(GltfKeys, OfBladesThatJumpBeginAndEndAsTheyAreSeen) {
  GltfOptions keys;
  keys.at_keys = true;
  const Scene scene = load_gltf(kData / "propeller.glb", keys);
  ASSERT_EQ(scene.meshes.size(), 5u);
  EXPECT_TRUE(scene.meshes[0].is_static());
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.is_static()) continue;
    const TimeRange range = mesh.motion_range();
    EXPECT_LT(range.begin, range.end);
    EXPECT_GT(mesh.steps.size(), 2u);
    if (!mesh.has_step_times()) continue;
    EXPECT_TRUE(std::is_sorted(mesh.step_times.begin(), mesh.step_times.end(), std::less_equal<>()));
  }
}

}  // namespace
}  // namespace stbvh::harness
