/// Pictures as a whole: the same whatever renders them, stopped, refused; the camera's lens and shutter.
#include "harness/path_tracer/render.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "harness/path_tracer/pixel_layers.h"
#include "tests/harness/picture_scenes.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

/// Triangles of all materials and step counts, and of time ranges where `structure` takes unlike ones.
Scene example_scene(std::string_view structure = "stbvh-direct") {
  Scene scene = mixed_step_scene(200);
  if (!obstacle(structure, scene).empty()) {
    for (Mesh& mesh : scene.meshes) mesh.time_range = {};
  }
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    Material& material = scene.meshes[i].material;
    material.kind = static_cast<Material::Kind>(i % 4);
    material.color = {0.9f, 0.7f, 0.5f};
  }
  return scene;
}

bool is_equal(const LayeredImage& a, const LayeredImage& b) {
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    const std::vector<float>&x = a.channels[c].values, &y = b.channels[c].values;
    if (x.size() != y.size() || std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) != 0) return false;
  }
  for (std::size_t c = 0; c < a.id_channels.size(); ++c) {
    if (a.id_channels[c].values != b.id_channels[c].values) return false;
  }
  return true;
}

TEST(Rendering, DependsOnTheSeedNotOnThreads) {
  const Scene scene = example_scene();
  RenderSettings settings = small(50, 4);
  settings.threads = 1;
  const Rendering one = rendered(scene, settings);
  settings.threads = 2;
  const Rendering two = rendered(scene, settings);
  EXPECT_TRUE(is_equal(one.image, two.image));
  EXPECT_EQ(one.rays, two.rays);
  EXPECT_TRUE(one.is_complete);
  EXPECT_EQ(one.not_finite, 0u);
  settings.seed = 2;
  EXPECT_GT(differing_pixels(one.image, rendered(scene, settings).image), 50u * 50u / 2);
}

TEST(Rendering, IsTheSameThroughEveryStructure) {
  const RenderSettings settings = small(64, 8);
  for (std::string_view name : structure_names()) {
    const Scene scene = example_scene(name);
    const LayeredImage ours = rendered(scene, settings, "stbvh-direct").image;
    const LayeredImage image = rendered(scene, settings, name).image;
    const std::size_t differing = differing_pixels(ours, image);
    if (is_exact(name)) {
      EXPECT_EQ(differing, 0u) << name;
    } else {
      EXPECT_LE(differing, 64u * 64u / 100) << name;
    }
    EXPECT_EQ(image.find("nodes.N") != nullptr,
              (name.starts_with("stbvh-direct") && name != "stbvh-direct-scalar") || name == "stbvh-batch")
        << name;
  }
}

TEST(Rendering, CountsWhatRaysMeet) {
  Scene scene = example_scene();
  const LayeredImage image = rendered(scene, small(16, 2)).image;
  double nodes = 0, triangles = 0;
  for (float n : *image.find("nodes.N")) nodes += static_cast<double>(n);
  for (float n : *image.find("triangles.N")) triangles += static_cast<double>(n);
  EXPECT_GT(nodes, 16 * 16);
  EXPECT_GT(triangles, 1);
}

TEST(Rendering, NamesWhatIsSeen) {
  Scene scene;
  scene.meshes = {square(1), square(1, 1, [](Vec3 p, std::size_t) { return p + Vec3{0, 1, 0}; })};
  scene.camera = looking_down_at({0.2f, 1, -0.1f});
  LayeredImage image = rendered(scene, small(4, 2)).image;
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(image.id_channels[0].values[i], 1u);
    EXPECT_LE(image.id_channels[1].values[i], 1u);
    EXPECT_FLOAT_EQ((*image.find("albedo.R"))[i], 0.7f);
  }
  scene.camera.target = {90, 90, 90};
  image = rendered(scene, small(4, 2)).image;
  EXPECT_EQ(image.id_channels[0].values[5], kInvalidId);
  EXPECT_EQ(image.id_channels[1].values[5], kInvalidId);
  EXPECT_EQ((*image.find("depth.Z"))[5], 0);
  EXPECT_GT((*image.find("B"))[5], 0.1f) << "the sky that scenes without light get";
}

TEST(Rendering, ThatIsStoppedKeepsItsFinishedTiles) {
  const Scene scene = example_scene();
  RenderSettings settings = small(64, 2);
  settings.threads = 1;
  const auto structure = build_structure("stbvh-direct", scene, 0);
  const Rendering whole = render(scene, *structure, settings);
  std::atomic<bool> stop{false};
  double done = 0;
  const Rendering part = render(
      scene, *structure, settings,
      [&](double fraction) {
        EXPECT_GT(fraction, done);
        done = fraction;
        if (fraction >= 0.5) stop = true;
      },
      &stop);
  EXPECT_FALSE(part.is_complete);
  EXPECT_EQ(done, 0.5);
  std::size_t kept = 0, black = 0;
  for (std::size_t i = 0; i < 64 * 64; ++i) {
    const float value = (*part.image.find("R"))[i];
    if (value == 0) ++black;
    if (value == (*whole.image.find("R"))[i]) ++kept;
  }
  EXPECT_EQ(kept, 64u * 64u / 2);
  EXPECT_EQ(black, 64u * 64u / 2);
}

TEST(Rendering, RefusesWhatCannotBe) {
  const Scene scene = example_scene();
  const auto structure = build_structure("stbvh-direct", scene, 0);
  const auto refused = [&](const std::function<void(RenderSettings&)>& change) {
    RenderSettings settings = small(4, 1);
    change(settings);
    EXPECT_THROW(render(scene, *structure, settings), std::invalid_argument);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([](RenderSettings& s) { s.width = 0; });
  refused([](RenderSettings& s) { s.height = kMaxPictureSide + 1; });
  refused([](RenderSettings& s) { s.samples_per_pixel = 0; });
  refused([](RenderSettings& s) { s.samples_per_pixel = kMaxSamplesPerPixel + 1; });
  refused([](RenderSettings& s) { s.lens.radius = -1; });
  refused([&](RenderSettings& s) { s.lens.radius = nan; });
  refused([](RenderSettings& s) { s.lens.focus_distance = 0; });
  refused([](RenderSettings& s) { s.shutter = {.open = 0.6, .close = 0.5}; });
  refused([](RenderSettings& s) { s.shutter.close = 1.5; });
  refused([&](RenderSettings& s) { s.shutter.open = nan; });
  refused([](RenderSettings& s) { s.shutter.opening = s.shutter.closing = 0.6; });
  const auto refused_scene = [&](const std::function<void(Scene&)>& change) {
    Scene changed = scene;
    change(changed);
    EXPECT_THROW(render(changed, *structure, small(4, 1)), std::invalid_argument);
  };
  refused_scene([](Scene& s) { s.camera.target = s.camera.position; });
  refused_scene([](Scene& s) { s.camera.up = {0, 0, 1}; });
  refused_scene([](Scene& s) { s.camera.vertical_fov_degrees = 180; });
  refused_scene([](Scene& s) { s.camera.position.x = std::nanf(""); });
  refused_scene([](Scene& s) { s.meshes[1].steps.clear(); });
  refused_scene([](Scene& s) { s.meshes[1].steps[1] = VertexBuffer(3); });
  refused_scene([](Scene& s) { s.meshes[1].time_range = {0.5f, 0.5f}; });
  refused_scene([](Scene& s) { s.meshes[1].step_times.assign(s.meshes[1].steps.size() + 1, 0); });
  refused_scene([](Scene& s) { s.meshes[1].step_times.assign(s.meshes[1].steps.size(), 0.5f); });
  refused_scene([](Scene& s) { s.meshes[1].material.color = {2, 0, 0}; });
}

TEST(PixelSums, CountWhatIsNotFiniteAndLeaveItOut) {
  LayeredImage image = empty_layers(1, 1, false);
  PixelSums sums;
  PathSample sample;
  sample.radiance = {1, 2, 3};
  sums.add(sample);
  sample.radiance = {1, std::nan(""), 3};
  sums.add(sample);
  sample.radiance = {std::numeric_limits<double>::infinity(), 0, 0};
  sums.add(sample);
  sample.radiance = {2, 4, 6};
  sums.add(sample);
  EXPECT_EQ(sums.not_finite(), 2u);
  sums.store(image, 0);
  EXPECT_FLOAT_EQ((*image.find("G"))[0], 1.5f);
  EXPECT_FLOAT_EQ((*image.find("variance.R"))[0], (1 + 0 + 0 + 4 - 4 * 0.5625f) / 12);
}

TEST(LensCamera, IsSharpAtTheFocusAlone) {
  const Camera camera{
      .position = {1, 2, 3}, .target = {1, 2, -7}, .up = {0, 1, 0}, .vertical_fov_degrees = 40};
  const LensCamera lens(camera, {.radius = 0.5, .focus_distance = 4}, 64, 48);
  for (std::uint32_t i = 0; i < 64; ++i) {
    const PixelPosition at{3.0 * (i % 20), 2.5 * (i % 19)};
    const CameraRay sharp = lens.ray(at, {0.5, 0.5}), other = lens.ray(at, scrambled_sobol(i, 1));
    EXPECT_NEAR(length(other.direction), 1, 1e-12);
    EXPECT_LE(length(other.origin - Vec3{1, 2, 3}), 0.5);
    const auto along = [](const CameraRay& r, double depth) {  // the point of the ray at z = 3 - depth
      return r.origin + (-depth / r.direction.z) * r.direction;
    };
    EXPECT_NEAR(length(along(sharp, 4) - along(other, 4)), 0, 1e-9);
    EXPECT_NEAR(length(along(sharp, 12) - along(other, 12)), 2 * length(other.origin - sharp.origin), 1e-9);
    const auto pixel = lens.project(along(other, 4));
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x, at.x, 1e-9);
    EXPECT_NEAR(pixel->y, at.y, 1e-9);
  }
  EXPECT_FALSE(lens.project({1, 2, 4}));
}

TEST(Shutter, LetsThroughWhatItsCurveSays) {
  for (const Shutter& shutter :
       {Shutter{}, Shutter{0.2, 0.6}, Shutter{0, 1, 0.5, 0.5}, Shutter{0.1, 0.9, 0.25, 0.25},
        Shutter{0, 1, 0.7, 0.1}, Shutter{0.5, 0.5, 0.5, 0.5}}) {
    const auto weight = [&](double f) {
      if (f < shutter.opening) return f / shutter.opening;
      return 1 - f < shutter.closing ? (1 - f) / shutter.closing : 1.0;
    };
    double all = 0, so_far = 0;
    constexpr int kCount = 10000;
    for (int i = 0; i < kCount; ++i) all += weight((i + 0.5) / kCount);
    for (int i = 0; i < kCount; ++i) {
      const double expected = shutter.open + (shutter.close - shutter.open) * (i + 0.5) / kCount;
      ASSERT_NEAR(shutter.time_at((so_far + 0.5 * weight((i + 0.5) / kCount)) / all), expected, 1e-4);
      so_far += weight((i + 0.5) / kCount);
    }
    EXPECT_GE(shutter.time_at(0), static_cast<float>(shutter.open));
    EXPECT_LE(shutter.time_at(std::nextafter(1.0, 0.0)), static_cast<float>(shutter.close));
  }
}

}  // namespace
}  // namespace stbvh::harness
