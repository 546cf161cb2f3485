/// The preview without its window: pictures that grow, what is shown of them, scenes in the background.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "harness/images/tone_map.h"
#include "harness/path_tracer/render.h"
#include "harness/preview/animation.h"
#include "harness/preview/camera_controller.h"
#include "harness/preview/growing_picture.h"
#include "harness/preview/preview_script.h"
#include "harness/preview/view_composer.h"
#include "harness/program/usage_error.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

const std::atomic<bool> kNoStop{false};

BuiltStructurePtr built(const std::shared_ptr<const Scene>& scene, const char* name) {
  return std::make_shared<BuiltStructure>(
      BuiltStructure{scene, scene->name, name, build_structure(name, *scene, 2)});
}

RenderSettings small_settings() {
  RenderSettings settings;
  settings.width = 45;  // neither a multiple of tiles nor of coarse squares
  settings.height = 37;
  return settings;
}

/// Misses the triangles of one of `count` kinds.
class Holey final : public StructureUnderTest {
 public:
  Holey(const Scene& scene, std::uint32_t count)
      : whole_(build_structure("embree-robust", scene, 1)), count_(count) {}
  const BuildRecord& build_record() const override { return whole_->build_record(); }
  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override {
    whole_->intersect(rays, hits);
  }
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override {
    whole_->occluded(rays, hits);
  }
  bool intersect_one(const Ray& ray, Hit& hit) const override {
    Hit found;
    if (!whole_->intersect_one(ray, found) || found.prim_id % count_ == 0) return false;
    hit = found;
    return true;
  }
  bool occluded_one(const Ray& ray) const override { return whole_->occluded_one(ray); }

 private:
  std::unique_ptr<StructureUnderTest> whole_;
  std::uint32_t count_;
};

class Growing : public ::testing::Test {
 protected:
  void grow(const BuiltPair& pair, std::size_t samples) {
    picture.begin(pair, small_settings());
    for (std::size_t i = 0; i + 1 < GrowingPicture::kCoarsePasses + samples; ++i)
      ASSERT_TRUE(picture.add_pass(kNoStop));
    EXPECT_EQ(picture.figures().samples, samples);
  }

  std::shared_ptr<const Scene> scene = std::make_shared<const Scene>(mixed_step_scene());
  WorkCrew crew{3};
  GrowingPicture picture{crew};
};

TEST_F(Growing, EndsAtWhatRenderMakes) {
  const BuiltPair pair{built(scene, "stbvh-direct"), built(scene, "embree")};
  grow(pair, 3);
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    RenderSettings settings = small_settings();
    settings.samples_per_pixel = 3;
    const Rendering truth = render(*scene, *pair[slot]->structure, settings);
    const Rendering grown = picture.rendering(slot);
    EXPECT_EQ(grown.rays, truth.rays);
    ASSERT_EQ(grown.image.channels.size(), truth.image.channels.size());
    for (std::size_t c = 0; c < truth.image.channels.size(); ++c)
      EXPECT_EQ(grown.image.channels[c].values, truth.image.channels[c].values)
          << truth.image.channels[c].name;
    for (std::size_t c = 0; c < truth.image.id_channels.size(); ++c)
      EXPECT_EQ(grown.image.id_channels[c].values, truth.image.id_channels[c].values);
  }
}

TEST_F(Growing, IsCoarseAtFirstAndFinerWithEachPass) {
  picture.begin({built(scene, "stbvh-direct"), nullptr}, small_settings());
  ViewComposer composer;
  std::size_t colors_before = 0;
  for (std::size_t pass = 0; pass < GrowingPicture::kCoarsePasses; ++pass) {
    ASSERT_TRUE(picture.add_pass(kNoStop));
    const std::size_t side = Tiling::kSide >> pass;
    const Image image = composer.compose(*picture.shown(), {});
    std::set<std::array<std::uint8_t, 3>> colors;
    for (std::size_t y = 0; y < image.height; ++y) {
      for (std::size_t x = 0; x < image.width; ++x) {
        const auto color = [&](std::size_t u, std::size_t v) {
          const std::uint8_t* p = &image.rgb[3 * (v * image.width + u)];
          return std::array<std::uint8_t, 3>{p[0], p[1], p[2]};
        };
        colors.insert(color(x, y));
        ASSERT_EQ(color(x, y), color(x / side * side, y / side * side)) << "pass " << pass;
      }
    }
    EXPECT_GT(colors.size(), colors_before) << "pass " << pass;
    colors_before = colors.size();
  }
}

TEST_F(Growing, EqualStructuresDifferInNothing) {
  grow({built(scene, "stbvh-direct"), built(scene, "stbvh-direct")}, 2);
  const PictureFigures figures = picture.figures();
  EXPECT_EQ(figures.compared, 2u * 45 * 37);
  EXPECT_EQ(figures.mismatches, 0u);
  EXPECT_EQ(figures.leaks[0] + figures.leaks[1], 0u);
  EXPECT_EQ(figures.rays[0], figures.rays[1]);
  EXPECT_GT(figures.mrays_per_thread_second(1), 0);
  const Image image = ViewComposer().compose(*picture.shown(), {.mode = ViewMode::kDifference, .gain = 1e9});
  for (std::uint8_t byte : image.rgb) ASSERT_EQ(byte, 0);
}

TEST_F(Growing, CountsTheLeaksOfTheStructureThatLeaks) {
  auto holey = std::make_shared<BuiltStructure>(
      BuiltStructure{scene, "", "holey", std::make_unique<Holey>(*scene, 5)});
  const BuiltStructurePtr whole = built(scene, "stbvh-direct");
  grow({holey, whole}, 1);
  const PictureFigures figures = picture.figures();
  EXPECT_GT(figures.leaks[0], 20u);
  EXPECT_EQ(figures.leaks[1], 0u);
  // Each leak is one: the triangle is hit however things move, but for those at an edge.
  EXPECT_LE(figures.leaks[0], figures.mismatches);
  EXPECT_GE(figures.leaks[0], figures.mismatches * 9 / 10);
  grow({whole, holey}, 1);
  EXPECT_EQ(picture.figures().leaks[0], 0u);
  EXPECT_EQ(picture.figures().leaks[1], figures.leaks[0]);
}

TEST_F(Growing, StopsInAPassAndBeginsAnew) {
  const BuiltPair pair{built(scene, "stbvh-direct"), nullptr};
  picture.begin(pair, small_settings());
  const std::atomic<bool> stop{true};
  EXPECT_FALSE(picture.add_pass(stop));
  grow(pair, 1);
}

TEST_F(Growing, RefusesWhatCannotBeShown) {
  RenderSettings settings = small_settings();
  settings.width = 0;
  const BuiltPair pair{built(scene, "stbvh-direct"), nullptr};
  EXPECT_THROW(picture.begin(pair, settings), std::invalid_argument);
  settings = small_settings();
  settings.camera = Camera{.position = {0, 0, 0}, .target = {0, 0, 0}};
  EXPECT_THROW(picture.begin(pair, settings), std::invalid_argument);
  grow(pair, 1);
}

/// A picture of two structures whose pixels all are as given.
std::shared_ptr<ShownPicture> plain_picture(const ShownPixel& pixel, std::size_t slots = 2) {
  auto picture = std::make_shared<ShownPicture>(40, 20);
  const Tiling tiles(40, 20);
  for (std::size_t i = 0; i < tiles.count(); ++i)
    picture->fill(tiles[i], tiles[i].x0, tiles[i].y0, Tiling::kSide, pixel);
  picture->slots = slots;
  picture->has_counters = {true, false};
  return picture;
}

std::array<int, 3> color_at(const Image& image, std::size_t x, std::size_t y) {
  const std::uint8_t* p = &image.rgb[3 * (y * image.width + x)];
  return {p[0], p[1], p[2]};
}

TEST(ViewComposer, SplitShowsAOnTheLeftAndBOnTheRight) {
  ShownPixel pixel;
  pixel.radiance = {{{0.5f, 0.1f, 0}, {0, 0.2f, 3}}};
  const auto picture = plain_picture(pixel);
  const ViewComposer composer;
  const Image image = composer.compose(*picture, {.mode = ViewMode::kSplit, .split = 0.25});
  for (std::size_t x = 0; x < 40; ++x) {
    const std::size_t slot = x < 10 ? 0 : 1;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(color_at(image, x, 7)[c], srgb_byte(tone_mapped(pixel.radiance[slot][c])), 1);
    }
  }
  const Image a = composer.compose(*picture, {.mode = ViewMode::kA});
  const Image b = composer.compose(*picture, {.mode = ViewMode::kB});
  EXPECT_EQ(color_at(a, 39, 0), color_at(image, 9, 0));
  EXPECT_EQ(color_at(b, 0, 19), color_at(image, 10, 0));
  for (double share : {-3.0, 0.0, 1.0, 7.0}) {
    const Image whole = composer.compose(*picture, {.mode = ViewMode::kSplit, .split = share});
    EXPECT_EQ(whole.rgb, share > 0.5 ? a.rgb : b.rgb);
  }
}

TEST(ViewComposer, ShowsOneStructureAloneWhereThereIsOne) {
  ShownPixel pixel;
  pixel.radiance[0] = {0.5f, 0.5f, 0.5f};
  const auto picture = plain_picture(pixel, 1);
  const ViewComposer composer;
  const Image a = composer.compose(*picture, {.mode = ViewMode::kA});
  EXPECT_EQ(composer.compose(*picture, {.mode = ViewMode::kB}).rgb, a.rgb);
  EXPECT_EQ(composer.compose(*picture, {.mode = ViewMode::kSplit, .split = 0.2}).rgb, a.rgb);
}

TEST(ViewComposer, HeatMapsAndStructuresThatDoNotCount) {
  ShownPixel pixel;
  pixel.nodes = {40, 0};
  pixel.triangles = {80, 0};
  const auto picture = plain_picture(pixel);
  const ViewComposer composer;
  ViewOptions options{.mode = ViewMode::kSplit, .heat = HeatMap::kNodes, .heat_largest = 80};
  const Image nodes = composer.compose(*picture, options);
  options.heat = HeatMap::kTriangles;
  const Image triangles = composer.compose(*picture, options);
  EXPECT_NE(color_at(nodes, 0, 0), color_at(triangles, 0, 0));
  EXPECT_GT(color_at(triangles, 0, 0)[0], color_at(nodes, 0, 0)[0]);
  EXPECT_EQ(color_at(nodes, 39, 0), (std::array<int, 3>{60, 60, 60}));
}

TEST(ViewComposer, DisplaysEveryRadianceAsToneMappingDoes) {
  ShownPixel pixel;
  const ViewComposer composer;
  for (float radiance :
       {0.0f, -0.0f, -1.0f, 1e-8f, 1e-4f, 0.01f, 0.1f, 0.5f, 0.6f, 0.9f, 2.0f, 50.0f, 1e9f, INFINITY, NAN}) {
    pixel.radiance[0] = {radiance, radiance, radiance};
    const Image image = composer.compose(*plain_picture(pixel, 1), {});
    EXPECT_NEAR(color_at(image, 0, 0)[0], srgb_byte(tone_mapped(radiance)), 1) << radiance;
  }
}

TEST(CameraController, OrbitKeepsTheDistanceAndComesBackAfterAWholeTurn) {
  CameraController controller(Camera{.position = {0, 1, 5}, .target = {1, 0, 0}});
  const auto distance = [&] {
    const Camera c = controller.camera();
    return std::hypot(c.position.x - 1.0f, c.position.y, c.position.z);
  };
  const float before = distance();
  for (int i = 0; i < 12; ++i) {
    controller.orbit(30, 0);
    EXPECT_NEAR(distance(), before, 1e-4);
  }
  EXPECT_NEAR(controller.camera().position.x, 0, 1e-4);
  EXPECT_NEAR(controller.camera().position.z, 5, 1e-4);
}

TEST(CameraController, OrbitGoesUpAndStopsAtTheTop) {
  CameraController controller(Camera{.position = {0, 0, 5}, .target = {0, 0, 0}});
  controller.orbit(0, 30);
  EXPECT_NEAR(controller.camera().position.y, 2.5, 1e-4);
  for (int i = 0; i < 20; ++i) {
    controller.orbit(10, 25);
    EXPECT_NO_THROW(LensCamera(controller.camera(), {}, 10, 10));
  }
  EXPECT_NEAR(controller.camera().position.y, 5, 1e-3);
  controller.orbit(0, -1000);
  EXPECT_NEAR(controller.camera().position.y, -5, 1e-3);
}

TEST(CameraController, PanDollyAndFocus) {
  CameraController controller(Camera{.position = {0, 0, 5}, .target = {0, 0, 0}, .vertical_fov_degrees = 90});
  controller.pan(0.5, 0);  // half of the 10 units that the picture has at the pivot's distance
  EXPECT_NEAR(controller.camera().position.x, 5, 1e-4);
  EXPECT_NEAR(controller.camera().target.x, 5, 1e-4);
  controller.dolly(0.5);
  EXPECT_NEAR(controller.camera().position.z, 2.5, 1e-4);
  controller.focus({5, 1, 1.5});
  EXPECT_NEAR(controller.camera().position.z, 2.5, 1e-4) << "nothing moves";
  EXPECT_NEAR(controller.camera().target.z, 1.5, 1e-4) << "the depth of the point is sharp";
  controller.focus({5, 1, 100});
  EXPECT_NEAR(controller.camera().target.z, 1.5, 1e-4) << "what is behind is not taken";
}

TEST(CameraController, StaysWhereRaysComeFrom) {
  CameraController controller(Camera{.position = {0, 0, 5}, .target = {0, 0, 0}});
  controller.dolly(1e30);
  controller.pan(1e30, -1e30);
  controller.pan(1e308, 1e308);
  EXPECT_EQ(controller.camera().position.z, 5);
  EXPECT_EQ(controller.camera().position.x, 0);
  controller.dolly(1e17);
  EXPECT_EQ(controller.camera().position.z, 5e17f);
}

TEST(Animation, ShutterOfEachFrame) {
  Animation animation;
  EXPECT_EQ(animation.shutter().close, 1);
  animation.is_whole = false;
  animation.frames = 10;
  animation.shutter_share = 0.5;
  animation.scrub(0.3);
  EXPECT_DOUBLE_EQ(animation.shutter().open, 0.3);
  EXPECT_DOUBLE_EQ(animation.shutter().close, 0.35);
  animation.is_frozen = true;
  EXPECT_DOUBLE_EQ(animation.shutter().close, 0.3);
  animation.is_frozen = false;
  animation.is_playing = true;
  animation.seconds = 1;
  animation.scrub(0);
  std::set<double> opened;
  for (int i = 0; i < 100; ++i) {
    animation.advance(0.0217);
    const Shutter shutter = animation.shutter();
    EXPECT_NO_THROW(check_shutter(shutter));
    opened.insert(shutter.open);
  }
  EXPECT_EQ(opened.size(), 10u);
}

TEST(PreviewScript, RefusesWhatItDoesNotKnowAndSaysWhere) {
  const auto problem = [](const std::string& text) -> std::string {
    try {
      parse_script(text);
    } catch (const UsageError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(problem("# nothing\n\n orbit 30 10  # round\nclose\n"), "");
  EXPECT_NE(problem("orbit 1 2\norbitt 1 2\n").find("Line 2"), std::string::npos);
  EXPECT_NE(problem("orbitt 1 2\n").find("did you mean \"orbit\""), std::string::npos);
  EXPECT_NE(problem("orbit 1\n").find("2 words"), std::string::npos);
  EXPECT_NE(problem("split half\n").find("not a number"), std::string::npos);
  EXPECT_NE(problem("split nan\n").find("not a number"), std::string::npos);
  EXPECT_THROW(read_script("/nowhere/script"), UsageError);
  EXPECT_THROW(read_script("/tmp"), UsageError);
}

}  // namespace
}  // namespace stbvh::harness
