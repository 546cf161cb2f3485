/// Comparing pictures: figures worked out by hand, and FLIP against values of its authors' own program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "harness/images/compare.h"
#include "harness/images/exr_file.h"
#include "harness/images/flip.h"
#include "harness/images/heat_map.h"
#include "harness/images/tone_map.h"
#include "plugin/files/output_file.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

using Rgb = std::array<float, 3>;

template <class Function>
LayeredImage picture_of(std::size_t width, std::size_t height, Function rgb) {
  LayeredImage image;
  image.width = width;
  image.height = height;
  image.channels = {{"R", {}}, {"G", {}}, {"B", {}}};
  for (std::size_t i = 0; i < width * height; ++i) {
    const Rgb color = rgb(i % width, i / width);
    for (std::size_t c = 0; c < 3; ++c) image.channels[c].values.push_back(color[c]);
  }
  return image;
}

LayeredImage flat(std::size_t width, std::size_t height, Rgb color) {
  return picture_of(width, height, [&](std::size_t, std::size_t) { return color; });
}

LayeredImage noisy(float deviation) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise;
  return picture_of(48, 32, [&](std::size_t x, std::size_t y) {
    const float base = 0.2f + 0.3f * static_cast<float>((x / 8 + y / 8) % 2);
    return Rgb{base + deviation * noise(random), base + deviation * noise(random),
               base + deviation * noise(random)};
  });
}

TEST(Compare, OfTheSamePictureIsZero) {
  const Comparison c = compare(noisy(0.1f), noisy(0.1f));
  EXPECT_EQ(c.rmse, 0);
  EXPECT_EQ(c.relative_mse, 0);
  EXPECT_EQ(c.flip_mean, 0);
  EXPECT_EQ(c.flip_max, 0);
  EXPECT_EQ(c.differing, 0u);
  EXPECT_TRUE(c.worst.empty());
}

TEST(Compare, FiguresAreThoseWorkedOutByHand) {
  const LayeredImage reference = flat(2, 2, {0.5f, 0.5f, 0.5f});
  LayeredImage picture = reference;
  picture.channels[0].values[1] = 0.75f;  // R of pixel (1, 0)
  picture.channels[2].values[2] = 0.0f;   // B of pixel (0, 1)
  const Comparison c = compare(picture, reference);
  EXPECT_NEAR(c.rmse, std::sqrt((0.25 * 0.25 + 0.5 * 0.5) / 12), 1e-12);
  EXPECT_NEAR(c.relative_mse, (0.25 * 0.25 + 0.5 * 0.5) / (0.25 + 0.01) / 12, 1e-12);
  EXPECT_EQ(c.differing, 2u);
  ASSERT_EQ(c.worst.size(), 2u);
  EXPECT_EQ(c.worst[0].x, 0u);
  EXPECT_EQ(c.worst[0].y, 1u);
  EXPECT_EQ(c.worst[0].picture, (Rgb{0.5f, 0.5f, 0.0f}));
  EXPECT_EQ(c.worst[0].reference, (Rgb{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(c.worst[1].x, 1u);
  EXPECT_EQ(c.worst[1].y, 0u);
}

TEST(Compare, RmseAndFlipAreSymmetricRelativeMseIsNot) {
  const LayeredImage dark = flat(4, 4, {0.1f, 0.1f, 0.1f});
  const LayeredImage light = flat(4, 4, {0.9f, 0.2f, 0.4f});
  const Comparison there = compare(dark, light);
  const Comparison back = compare(light, dark);
  EXPECT_EQ(there.rmse, back.rmse);
  EXPECT_EQ(there.flip_mean, back.flip_mean);
  EXPECT_LT(there.relative_mse, back.relative_mse);
}

TEST(Compare, GrowsWithNoise) {
  const LayeredImage reference = noisy(0);
  Comparison last = compare(reference, reference);
  for (float deviation : {0.01f, 0.03f, 0.1f, 0.2f}) {
    const Comparison c = compare(noisy(deviation), reference);
    EXPECT_GT(c.rmse, last.rmse);
    EXPECT_GT(c.relative_mse, last.relative_mse);
    EXPECT_GT(c.flip_mean, last.flip_mean);
    EXPECT_NEAR(c.rmse, static_cast<double>(deviation), 0.05 * static_cast<double>(deviation));
    last = c;
  }
}

TEST(Compare, PixelsThatAreNotFiniteAreCountedAndLeftOut) {
  const LayeredImage reference = flat(8, 8, {0.5f, 0.5f, 0.5f});
  LayeredImage picture = reference;
  picture.channels[1].values[3] = std::numeric_limits<float>::quiet_NaN();
  picture.channels[0].values[9] = std::numeric_limits<float>::infinity();
  const Comparison c = compare(picture, reference);
  EXPECT_EQ(c.not_finite, 2u);
  EXPECT_EQ(c.differing, 2u);
  ASSERT_EQ(c.worst.size(), 2u);
  EXPECT_TRUE(std::isnan(c.worst[0].picture[1]));
  EXPECT_EQ(c.rmse, 0);
  EXPECT_EQ(c.flip_mean, 0);
  EXPECT_EQ(std::count_if(c.flip_map.begin(), c.flip_map.end(), [](float v) { return std::isnan(v); }), 2);
  const Image map = heat_map(c.flip_map, 8, 8, 1);
  const std::array<std::uint8_t, 3> painted{map.rgb[27], map.rgb[28], map.rgb[29]};  // of pixel 9
  EXPECT_EQ(painted, kNotFiniteColor);
}

TEST(Compare, WhatIsNotFiniteIsTheSameAsItsLikeOnly) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto differing = [](float a, float b) {
    LayeredImage picture = flat(2, 1, {0, 0, 0}), reference = picture;
    picture.channels[1].values[1] = a;
    reference.channels[1].values[1] = b;
    const Comparison c = compare(picture, reference);
    EXPECT_EQ(c.not_finite, 1u);
    return c.differing;
  };
  EXPECT_EQ(differing(nan, nan), 0u);
  EXPECT_EQ(differing(nan, -nan), 0u);
  EXPECT_EQ(differing(inf, inf), 0u);
  EXPECT_EQ(differing(inf, -inf), 1u);
  EXPECT_EQ(differing(inf, nan), 1u);
  EXPECT_EQ(differing(nan, 0), 1u);
  EXPECT_EQ(differing(0, -inf), 1u);
}

TEST(Compare, TheWorstPixelsAreThoseFiniteInOneOnly) {
  const LayeredImage reference = flat(4, 1, {0, 0, 0});
  LayeredImage picture = reference;
  picture.channels[0].values = {1, 2, std::numeric_limits<float>::quiet_NaN(), 3};
  const Comparison c = compare(picture, reference);
  ASSERT_EQ(c.worst.size(), 4u);
  EXPECT_EQ(c.worst[0].x, 2);
  EXPECT_EQ(c.worst[1].x, 3);
  EXPECT_EQ(c.worst[3].x, 0);
}

/// Pixels of a shot: the values depend on the place only.
LayeredImage part_of_shot(PixelWindow window) {
  LayeredImage image = picture_of(window.width, window.height, [&](std::size_t x, std::size_t y) {
    const auto at_x = static_cast<float>(window.left + static_cast<std::int64_t>(x));
    const auto at_y = static_cast<float>(window.top + static_cast<std::int64_t>(y));
    return Rgb{at_x / 64, at_y / 64, at_x * at_y / 4096};
  });
  image.left = window.left;
  image.top = window.top;
  image.display = PixelWindow{0, 0, 40, 30};
  return image;
}

TEST(Compare, HoldsPixelsAgainstThoseAtTheSamePlace) {
  const LayeredImage whole = part_of_shot({0, 0, 40, 30});
  for (const PixelWindow window :
       {PixelWindow{10, 5, 20, 20}, {-8, -3, 60, 50}, {30, 20, 40, 30}, {39, 29, 1, 1}}) {
    const LayeredImage part = part_of_shot(window);
    const Comparison c = compare(part, whole);
    EXPECT_EQ(c.differing, 0u) << window.left;
    EXPECT_EQ(c.flip_max, 0);
    EXPECT_EQ(c.width * c.height + c.only_in_picture, window.width * window.height);
    EXPECT_EQ(c.width * c.height + c.only_in_reference, 1200u);
    EXPECT_EQ(c.flip_map.size(), c.width * c.height);
    EXPECT_TRUE(c.warnings.empty());
    const Comparison back = compare(whole, part);
    EXPECT_EQ(back.only_in_picture, c.only_in_reference);
  }
  const Comparison corner = compare(part_of_shot({30, 20, 40, 30}), whole);
  EXPECT_EQ(corner.left, 30);
  EXPECT_EQ(corner.top, 20);
  EXPECT_EQ(corner.width, 10u);
  EXPECT_EQ(corner.height, 10u);
}

TEST(Compare, SamePixelsAtOtherPlacesDiffer) {
  const LayeredImage whole = part_of_shot({0, 0, 40, 30});
  LayeredImage moved = whole;
  moved.left = 3;
  const Comparison c = compare(moved, whole);
  EXPECT_EQ(c.width, 37u);
  EXPECT_EQ(c.differing, 37u * 30u);
  EXPECT_EQ(c.only_in_picture, 90u);
  ASSERT_FALSE(c.worst.empty());
  EXPECT_GE(c.worst[0].x, 3);
  EXPECT_NEAR(c.rmse, std::sqrt((std::pow(3.0 / 64, 2) + std::pow(3.0 / 4096, 2) * 29 * 59 / 6) / 3), 1e-6);
}

TEST(Compare, PicturesThatShareNoPlaceAreRefused) {
  const LayeredImage whole = part_of_shot({0, 0, 40, 30});
  EXPECT_THROW(compare(part_of_shot({40, 0, 5, 5}), whole), ComparisonError);
  EXPECT_THROW(compare(part_of_shot({0, -5, 5, 5}), whole), ComparisonError);
}

TEST(Compare, WarnsOfWhatPixelsDoNotSay) {
  const LayeredImage reference = part_of_shot({0, 0, 40, 30});
  const auto warning = [&](const LayeredImage& picture) {
    const Comparison c = compare(picture, reference);
    EXPECT_EQ(c.differing, 0u);
    EXPECT_EQ(c.warnings.size(), 1u);
    return c.warnings.empty() ? "" : c.warnings[0];
  };
  LayeredImage other = reference;
  other.display = PixelWindow{0, 0, 100, 100};
  EXPECT_NE(warning(other).find("display windows differ: 100 x 100"), std::string::npos);
  other = reference;
  other.chromaticities[0] = 0.708f;
  EXPECT_NE(warning(other).find("chromaticities are 0.708"), std::string::npos);
  other = reference;
  other.pixel_aspect = 2;
  EXPECT_NE(warning(other).find("2 times as wide"), std::string::npos);
  other = reference;
  other.white_luminance = 1000;
  EXPECT_NE(warning(other).find("another luminance in the two: 1000"), std::string::npos);
  other = reference;
  other.is_cube_map = true;
  EXPECT_NE(warning(other).find("The picture is the six sides of a cube"), std::string::npos);
  other = reference;
  other.channels.push_back({"depth.Z", other.channels[0].values});
  other.id_channels.push_back({"mesh.id", std::vector<std::uint32_t>(other.width * other.height)});
  EXPECT_EQ(warning(other), "Only the picture has depth.Z, mesh.id.");
}

TEST(Compare, WarnsOfAlphasThatDifferWhereBothHavePixels) {
  const auto with_alpha = [](const PixelWindow& window, float alpha) {
    LayeredImage image = part_of_shot(window);
    image.channels.push_back({"A", std::vector<float>(image.width * image.height, alpha)});
    return image;
  };
  const LayeredImage whole = with_alpha({0, 0, 40, 30}, 1);
  LayeredImage part = with_alpha({30, 20, 40, 30}, 1);
  EXPECT_TRUE(compare(part, whole).warnings.empty());
  part.channels[3].values.back() = 0;  // where the other has no pixels
  EXPECT_TRUE(compare(part, whole).warnings.empty());
  part.channels[3].values.front() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(compare(part, whole).warnings,
            std::vector<std::string>{"A, which is not compared, differs in 1 of 100 pixels."});
  EXPECT_TRUE(compare(part, part).warnings.empty());
}

TEST(Compare, ChromaticitiesThatAreNoNumbersAreTheSameAsThemselves) {
  LayeredImage picture = flat(4, 4, {0, 0, 0});
  picture.chromaticities[3] = picture.white_luminance = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(compare(picture, picture).warnings.empty());
  EXPECT_EQ(compare(picture, flat(4, 4, {0, 0, 0})).warnings.size(), 2u);
}

TEST(Compare, RefusesWhatCannotBeCompared) {
  const LayeredImage picture = flat(4, 4, {0, 0, 0});
  LayeredImage without_blue = picture;
  without_blue.channels.pop_back();
  EXPECT_THROW(compare(picture, flat(4, 5, {0, 0, 0})), ComparisonError);
  EXPECT_THROW(compare(picture, flat(2, 8, {0, 0, 0})), ComparisonError);
  EXPECT_THROW(compare(without_blue, picture), ComparisonError);
  EXPECT_THROW(compare(picture, without_blue), ComparisonError);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(compare(flat(4, 4, {0, nan, 0}), picture), ComparisonError);
}

float linear_from_srgb(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

/// A picture of sRGB values.
template <class Function>
DisplayedPicture displayed_of(std::size_t width, std::size_t height, Function srgb) {
  DisplayedPicture picture{.width = width, .height = height, .rgb = {}};
  for (std::size_t i = 0; i < width * height; ++i) {
    const Rgb color = srgb(i % width, i / width);
    for (std::size_t c = 0; c < 3; ++c) picture.rgb[c].push_back(linear_from_srgb(color[c]));
  }
  return picture;
}

DisplayedPicture flat_display(Rgb srgb) {
  return displayed_of(16, 16, [&](std::size_t, std::size_t) { return srgb; });
}

double mean(const std::vector<float>& values) {
  double total = 0;
  for (float v : values) total += static_cast<double>(v);
  return total / static_cast<double>(values.size());
}

/// Ramps and squares; the two of `shift` 0 and 1 have other edges, points and colours.
DisplayedPicture pattern(std::size_t shift) {
  return displayed_of(64, 48, [&](std::size_t x, std::size_t y) {
    return Rgb{static_cast<float>((x * 7 + y * 3 + shift * 11) % 32) / 31.0f,
               static_cast<float>((x * 2 + y * 5 + x / 8 * shift) % 48) / 47.0f,
               static_cast<float>((x / 8 + y / 8) % 2) * 0.8f + 0.1f};
  });
}

// What flip-evaluator 1.7 (its authors' program, from PyPI) says of the same pictures, inputsRGB=True.
TEST(Flip, IsWhatItsAuthorsProgramSays) {
  const std::vector<float> map = flip(pattern(0), pattern(1));
  EXPECT_NEAR(mean(map), 0.4169863, 2e-5);
  EXPECT_NEAR(map[0], 0.6110622f, 1e-4f);
  EXPECT_NEAR(map[10 * 64 + 20], 0.3896191f, 1e-4f);
  EXPECT_NEAR(map[47 * 64 + 63], 0.69574255f, 1e-4f);
  EXPECT_NEAR(*std::max_element(map.begin(), map.end()), 0.9730325f, 1e-4f);
}

TEST(Flip, OfAnEdgeAndADotIsWhatItsAuthorsProgramSays) {
  const DisplayedPicture grey = flat_display({0.2f, 0.2f, 0.2f});
  const DisplayedPicture edge = displayed_of(16, 16, [](std::size_t x, std::size_t) {
    return x < 8 ? Rgb{0.2f, 0.2f, 0.2f} : Rgb{0.7f, 0.7f, 0.7f};
  });
  const std::vector<float> at_edge = flip(grey, edge);
  EXPECT_NEAR(at_edge[8 * 16 + 4], 0.03751572f, 1e-4f);
  EXPECT_NEAR(at_edge[8 * 16 + 7], 0.76650953f, 1e-4f);
  EXPECT_NEAR(at_edge[8 * 16 + 15], 0.9187021f, 1e-4f);
  const DisplayedPicture dot = displayed_of(16, 16, [](std::size_t x, std::size_t y) {
    return x == 8 && y == 8 ? Rgb{1, 1, 1} : Rgb{0.5f, 0.5f, 0.5f};
  });
  const std::vector<float> at_dot = flip(flat_display({0.5f, 0.5f, 0.5f}), dot);
  EXPECT_NEAR(mean(at_dot), 0.01688305, 1e-5);
  EXPECT_NEAR(at_dot[8 * 16 + 8], 0.38019773f, 1e-4f);
}

TEST(Flip, IsOneAtMostBetweenGreenAndBlue) {
  const std::vector<float> map = flip(flat_display({0, 1, 0}), flat_display({0, 0, 1}));
  for (float value : map) EXPECT_NEAR(value, 1, 1e-5f);
  EXPECT_NEAR(mean(flip(flat_display({0, 0, 0}), flat_display({1, 1, 1}))), 0.96739, 1e-5);
}

TEST(Flip, SeesLessFromAfar) {
  const double near = mean(flip(pattern(0), pattern(1), 30));
  const double far = mean(flip(pattern(0), pattern(1), 120));
  EXPECT_GT(near, far);
}

TEST(ToneMap, IsMonotoneAndBounded) {
  float last = 0;
  for (float radiance = 0; radiance < 20; radiance += 0.01f) {
    const float shown = tone_mapped(radiance);
    EXPECT_GE(shown, last);
    EXPECT_LE(shown, 1);
    last = shown;
  }
  EXPECT_EQ(tone_mapped(0.5f), 0.5f);
  EXPECT_EQ(tone_mapped(-1.0f), 0);
  EXPECT_EQ(tone_mapped(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(srgb_byte(0), 0);
  EXPECT_EQ(srgb_byte(0.5f), 188);  // 1.055 * 0.5^(1 / 2.4) - 0.055 = 0.7354
  EXPECT_EQ(srgb_byte(1), 255);
}

TEST(HeatMap, GetsLighterWithTheValueAndShowsItsScale) {
  int last = -1;
  for (int i = 0; i <= 100; ++i) {
    const auto color = heat_color(i / 100.0);
    const int lightness = 2126 * color[0] + 7152 * color[1] + 722 * color[2];
    EXPECT_GT(lightness, last) << i;
    EXPECT_NE(color, kNotFiniteColor);
    last = lightness;
  }
  const std::vector<float> values(320 * 10, 3.0f);
  const Image map = heat_map(values, 320, 10, 4);
  EXPECT_EQ(map.width, 320u);
  EXPECT_GT(map.height, 10u);
  EXPECT_EQ(map.rgb.size(), 3 * map.width * map.height);
  EXPECT_EQ((std::array<std::uint8_t, 3>{map.rgb[0], map.rgb[1], map.rgb[2]}), heat_color(0.75));
  EXPECT_EQ(heat_map({values.data(), 1}, 1, 1, 4).width, 1u);  // no room for numbers
  EXPECT_THROW(heat_map(values, 10, 10, 4), std::invalid_argument);
  EXPECT_THROW(heat_map(values, 320, 10, 0), std::invalid_argument);
}

class CompareCommand : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    write_exr(noisy(0), at("a.exr"));
    write_exr(noisy(0.1f), at("b.exr"));
    write_exr(flat(3, 3, {0, 0, 0}), at("small.exr"));
    LayeredImage depth = flat(48, 32, {0, 0, 0});
    depth.channels = {{"depth.Z", depth.channels[0].values}};
    write_exr(depth, at("depth.exr"));
    write("broken.exr", "no picture");
  }

  void expect_refused(const std::string& arguments, const std::string& reason) {
    expect_refusal(stbvh_ab("compare " + arguments), reason);
  }
};

TEST_F(CompareCommand, WritesRecordAndPicture) {
  const Outcome run = stbvh_ab("compare " + at("b.exr") + " " + at("a.exr") + " --png " + at("d.png") +
                               " --json " + at("d.json"));
  ASSERT_EQ(run.exit_code, 0) << run.out;
  EXPECT_NE(run.out.find("RMSE"), std::string::npos);
  const auto record = nlohmann::json::parse(read_file(at("d.json"))).at("records").at(0);
  EXPECT_EQ(record.at("kind"), "compare");
  EXPECT_NEAR(record.at("rmse").get<double>(), 0.1, 0.005);
  EXPECT_EQ(record.at("worst").size(), kWorstPixels);
  EXPECT_EQ(record.at("differing"), 48 * 32);
  EXPECT_TRUE(read_file(at("d.png")).starts_with("\x89PNG"));
}

TEST_F(CompareCommand, SaysWhatIsNotComparedAndWarns) {
  LayeredImage moved = noisy(0);
  moved.left = 10;
  moved.top = 5;
  moved.display = PixelWindow{0, 0, 100, 100};
  moved.chromaticities = {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
  write_exr(moved, at("moved.exr"));
  const Outcome run = stbvh_ab("compare " + at("moved.exr") + " " + at("a.exr") + " --png " + at("d.png") +
                               " --json " + at("d.json"));
  ASSERT_EQ(run.exit_code, 0) << run.out;
  for (const char* part :
       {"38 x 27, ", "510 of the picture, 510 of the reference", "from (10, 5) on",
        "stbvh-ab: The display windows differ", "stbvh-ab: R, G and B are of other colors"}) {
    EXPECT_NE(run.out.find(part), std::string::npos) << part << run.out;
  }
  const auto record = nlohmann::json::parse(read_file(at("d.json"))).at("records").at(0);
  EXPECT_EQ(record.at("only_in_picture"), 510);
  EXPECT_EQ(record.at("left"), 10);
  EXPECT_EQ(record.at("warnings").size(), 2u);
  EXPECT_GT(record.at("differing"), 0);
}

TEST_F(CompareCommand, AnEnvironmentIsAWholeSphereOrRefused) {
  const auto rendered = [&](const LayeredImage& environment) {
    write_exr(environment, at("e.exr"));
    return stbvh_ab("render --scenes wheels --scale 0.01 --size 8x8 --spp 1 --environment " + at("e.exr") +
                    " -o " + at("out.exr"));
  };
  LayeredImage sphere = flat(8, 4, {1, 1, 1});
  EXPECT_EQ(rendered(sphere).exit_code, 0);
  sphere.chromaticities[0] = 0.708f;
  const Outcome warned = rendered(sphere);
  EXPECT_EQ(warned.exit_code, 0);
  EXPECT_NE(warned.out.find("other chromaticities than Rec. 709"), std::string::npos) << warned.out;
  LayeredImage part = flat(8, 4, {1, 1, 1});
  part.display = PixelWindow{0, 0, 16, 8};
  expect_refusal(rendered(part), "is not a whole sphere");
  LayeredImage cube = flat(4, 24, {1, 1, 1});
  cube.is_cube_map = true;
  expect_refusal(rendered(cube), "is a cube");
}

TEST_F(CompareCommand, RefusesInOneLine) {
  expect_refused(at("a.exr") + " " + at("small.exr"), "48 x 32");
  expect_refused(at("a.exr") + " " + at("depth.exr"), "no channel R");
  expect_refused(at("a.exr") + " " + at("none.exr"), "none.exr");
  expect_refused(at("broken.exr") + " " + at("a.exr"), "broken.exr");
  expect_refused(at("a.exr"), "reference");
  expect_refused(at("a.exr") + " " + at("b.exr") + " --png /no/such/d.png", "Cannot write");
  expect_refused(at("a.exr") + " " + at("b.exr") + " --json /no/such/d.json", "Cannot write");
}

TEST_F(CompareCommand, FullDiskIsReported) {
  if (!make_device("full", Device::kFull)) GTEST_SKIP() << "only root may make device nodes";
  const Outcome run = stbvh_ab("compare " + at("a.exr") + " " + at("b.exr") + " --png " + at("full"));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.out.find("Cannot write to \"" + at("full") + "\""), std::string::npos) << run.out;
}

}  // namespace
}  // namespace stbvh::harness
