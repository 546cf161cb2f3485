/// Motion blur against what it stands for: the mean of pictures taken at single moments.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "harness/scenes/frozen_scene.h"
#include "harness/scenes/procedural/shared/mesh_tools.h"
#include "tests/harness/picture_scenes.h"

namespace stbvh::harness {
namespace {

/// A sphere that swings, a square that tumbles and a light that passes, with 4, 6 and 3 steps, over a floor.
Scene moving_scene() {
  Scene scene;
  scene.meshes.push_back(square(6));
  scene.meshes.push_back(sphere(4, [](Vec3 p, std::size_t k) {
    constexpr std::array kHeights{0.3, 2.2, 0.3, 1.2};
    return 0.6 * p + Vec3{-1.5 + static_cast<double>(k), kHeights[k], 0};
  }));
  scene.meshes.push_back(square(0.8, 6, [](Vec3 p, std::size_t k) {
    return rotate(axis_angle({0, 0, 1}, 0.9 * static_cast<double>(k)), p) + Vec3{1.2, 1.3, 1};
  }));
  scene.meshes.push_back(square(0.5, 3, [](Vec3 p, std::size_t k) {
    return p + Vec3{-2 + 2 * static_cast<double>(k), k == 1 ? 1.5 : 3.0, -1};
  }));
  scene.meshes[0].material = white(0.6f);
  scene.meshes[1].material.color = {0.8f, 0.3f, 0.2f};
  scene.meshes[2].material.color = {0.2f, 0.3f, 0.8f};
  scene.meshes[2].time_range = {0.2f, 0.9f};
  scene.meshes[3].material.emission = {8, 8, 8};
  scene.environment = constant_environment(0.2f);
  scene.camera = {
      .position = {0, 2.5f, 8}, .target = {0, 0.8f, 0}, .up = {0, 1, 0}, .vertical_fov_degrees = 32};
  return scene;
}

/// Means of the pixels and the variances of these.
struct Mean {
  std::vector<double> values, variances;
};

Mean mean_of_frozen(const Scene& scene, RenderSettings settings, const std::vector<float>& times) {
  Mean mean{std::vector<double>(settings.width * settings.height), {}};
  mean.variances = mean.values;
  const auto n = static_cast<double>(times.size());
  for (float time : times) {
    ++settings.seed;  // else all of them have the same noise
    const LayeredImage image = rendered(frozen(scene, time), settings).image;
    for (std::size_t i = 0; i < mean.values.size(); ++i) {
      mean.values[i] += static_cast<double>((*image.find("G"))[i]) / n;
      mean.variances[i] += static_cast<double>((*image.find("variance.G"))[i]) / (n * n);
    }
  }
  return mean;
}

/// Mean square of the pixels' differences in units of their standard deviation: about 1 by chance alone, or
/// less, as stratified samples vary less than their variance says.
double discrepancy(const LayeredImage& image, const Mean& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.values.size(); ++i) {
    const double difference = static_cast<double>((*image.find("G"))[i]) - truth.values[i];
    sum += difference * difference /
           (static_cast<double>((*image.find("variance.G"))[i]) + truth.variances[i] + 1e-7);
  }
  return sum / static_cast<double>(truth.values.size());
}

constexpr int kMoments = 64;

TEST(MotionBlur, IsTheMeanOfManyMoments) {
  const Scene scene = moving_scene();
  std::vector<float> moments, on_coarse_grid;
  for (int i = 0; i < kMoments; ++i) {
    const float time = (static_cast<float>(i) + 0.5f) / kMoments;
    moments.push_back(time);
    on_coarse_grid.push_back(std::round(time * 5) / 5);
  }
  RenderSettings settings = small(24, 12);
  const Mean truth = mean_of_frozen(scene, settings, moments);
  const Mean quantised = mean_of_frozen(scene, settings, on_coarse_grid);
  settings.samples_per_pixel = 12 * kMoments;
  for (std::string_view structure : {"stbvh-direct", "embree", "lbvh"}) {
    const LayeredImage blurred = rendered(scene, settings, structure).image;
    EXPECT_LT(discrepancy(blurred, truth), 1.3) << structure;
    EXPECT_GT(discrepancy(blurred, quantised), 3) << "the test cannot tell moments apart";
  }
}

TEST(MotionBlur, OfATriangularShutterWeighsMoments) {
  const Scene scene = moving_scene();
  RenderSettings settings = small(24, 12);
  settings.shutter = {.open = 0.25, .close = 0.75, .opening = 0.5, .closing = 0.5};
  std::vector<float> moments, unweighted;
  for (int i = 0; i < kMoments; ++i) {
    const double number = (i + 0.5) / kMoments;
    // The inverse of the share of a triangle's area that lies before a time.
    const double fraction = number < 0.5 ? std::sqrt(number / 2) : 1 - std::sqrt((1 - number) / 2);
    moments.push_back(static_cast<float>(0.25 + 0.5 * fraction));
    unweighted.push_back(static_cast<float>(0.25 + 0.5 * number));
  }
  const Mean truth = mean_of_frozen(scene, settings, moments);
  const Mean of_a_box = mean_of_frozen(scene, settings, unweighted);
  settings.samples_per_pixel = 12 * kMoments;
  const LayeredImage blurred = rendered(scene, settings).image;
  EXPECT_LT(discrepancy(blurred, truth), 1.3);
  EXPECT_GT(discrepancy(blurred, of_a_box), 1.6) << "the test cannot tell shutters apart";
}

TEST(MotionBlur, OfAFrozenShutterIsAStillPicture) {
  const Scene scene = moving_scene();
  RenderSettings settings = small(24, 8);
  for (double time : {0.0, 0.5, 1.0 / 3, 0.77, 1.0}) {
    settings.shutter = {.open = time, .close = time};
    const LayeredImage blurred = rendered(scene, settings).image;
    const LayeredImage still = rendered(frozen(scene, static_cast<float>(time)), settings).image;
    // The still one's vertices are rounded to float: where that decides, a pixel may differ.
    double difference = 0;
    for (std::size_t i = 0; i < 24 * 24; ++i)
      difference +=
          static_cast<double>(std::abs((*blurred.find("R"))[i] - (*still.find("R"))[i])) / (24 * 24);
    EXPECT_LT(difference, 2e-4) << time;
  }
}

/// The same, from a camera that moves the other way past what stands still.
TEST(MotionBlur, OfACameraThatMovesIsThatOfTheScene) {
  Scene scene = moving_scene(), moved = scene;
  const auto shift = [](std::size_t k) { return Vec3{0.4 * static_cast<double>(k), 0, 0}; };
  scene.meshes.resize(1);
  moved.meshes.resize(1);
  scene.environment->radiance = moved.environment->radiance = {1, 1, 1};
  scene.meshes[0] = sphere();
  moved.meshes[0] = sphere(3, [&](Vec3 p, std::size_t k) { return p - shift(k); });
  for (std::size_t k = 0; k < 3; ++k) {
    Camera camera = scene.camera;
    camera.position = to_float(to_double(camera.position) + shift(k));
    camera.target = to_float(to_double(camera.target) + shift(k));
    scene.camera_steps.push_back(camera);
  }
  const LayeredImage a = rendered(scene, small(24, 16)).image, b = rendered(moved, small(24, 16)).image;
  for (const char* layer : {"depth.Z", "motion.X", "motion.Y", "normal.X"}) {
    double difference = 0, largest = 0;
    for (std::size_t i = 0; i < 24 * 24; ++i) {
      difference += std::abs((*a.find(layer))[i] - (*b.find(layer))[i]) / (24 * 24);
      largest = std::max(largest, std::abs(static_cast<double>((*a.find(layer))[i])));
    }
    EXPECT_LT(difference, 0.01 * largest + 1e-6) << layer;
  }
  EXPECT_NEAR((*a.find("motion.X"))[12 * 24 + 12], -0.8 / 8 * 24 / (2 * std::tan(16 * kPi / 180)), 0.5);
  // Half a turn in one step: there is no middle, but always a direction.
  scene.camera_steps = {scene.camera, scene.camera};
  scene.camera_steps[1].target.z = 16 - scene.camera.target.z;
  EXPECT_EQ(rendered(scene, small(8, 4)).not_finite, 0u);
}

TEST(MotionBlur, GivesTheMotionInPixels) {
  // One unit to the right at distance 10: the picture is 2 x 10 x tan(fov / 2) units high there.
  Scene scene;
  scene.meshes.push_back(square(3, 2, [](Vec3 p, std::size_t k) {
    return Vec3{p.x + static_cast<double>(k), p.z, 0};
  }));
  scene.camera = {.position = {0, 0, 10}, .target = {0, 0, 0}, .up = {0, 1, 0}, .vertical_fov_degrees = 20};
  RenderSettings settings = small(16, 4);
  settings.shutter = {.open = 0.25, .close = 0.75};
  const LayeredImage image = rendered(scene, settings).image;
  const double pixels = 0.5 * 16 / (20 * std::tan(10 * kPi / 180));
  EXPECT_NEAR((*image.find("motion.X"))[8 * 16 + 8], pixels, 1e-4);
  EXPECT_NEAR((*image.find("motion.Y"))[8 * 16 + 8], 0, 1e-4);
  EXPECT_NEAR((*image.find("depth.Z"))[8 * 16 + 8], 10, 0.02);
  EXPECT_NEAR((*image.find("time.T"))[8 * 16 + 8], 0.5, 0.13);
  EXPECT_NEAR((*image.find("normal.Z"))[8 * 16 + 8], 1, 1e-6);
}

}  // namespace
}  // namespace stbvh::harness
