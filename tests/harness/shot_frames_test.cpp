/// Frames of a shot: what of a file each of them shows, and the command that renders them.
#include "harness/cli/shot_frames.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "harness/images/exr_file.h"
#include "harness/program/usage_error.h"
#include "harness/scenes/gltf/gltf.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/gltf_files.h"
#include "tests/harness/run_stbvh_ab.h"

namespace stbvh::harness {
namespace {

using Numbers = std::vector<int>;

TEST(Frames, AreThoseOfOpenJobDescription) {
  EXPECT_EQ(parse_frames("7"), Numbers{7});
  EXPECT_EQ(parse_frames("1001-1004"), (Numbers{1001, 1002, 1003, 1004}));
  EXPECT_EQ(parse_frames("1-8:3"), (Numbers{1, 4, 7}));
  EXPECT_EQ(parse_frames("-3--1"), (Numbers{-3, -2, -1}));
  EXPECT_EQ(parse_frames("9,1-2,2-3"), (Numbers{1, 2, 3, 9}));
  for (const char* const bad :
       {"", ",", "1,", "4-1", "1-4:0", "1-4:-1", "a", "1-", "-", "1-2-3", "1.5", "1 2", " 1", "+1", "0x10",
        "999999999", "99999999999999999999", "1-90000000", "1-2:3:4"})
    EXPECT_THROW(parse_frames(bad), UsageError) << bad;
}

TEST(Takes, AreOneForEachFrame) {
  MakingOptions making;
  making.gltf.shutter = FilePart{-0.5, 0.25};
  const FrameOptions frames{.numbers = {10, 12}, .rate = 25};
  const std::vector<Take> takes =
      takes_of(frames, making, {.open = 0, .close = 0.5, .opening = 0.5, .closing = 0.5});
  ASSERT_EQ(takes.size(), 2u);
  const FilePart& second = *takes[1].making.gltf.shutter;
  EXPECT_EQ(second.begin, 11.5);
  EXPECT_EQ(second.end, 12.25);
  EXPECT_TRUE(second.is_in_frames);
  EXPECT_EQ(second.frame_rate, 25);
  ASSERT_EQ(takes[1].frames.size(), 1u);
  EXPECT_EQ(takes[1].frames[0].number, 12);
  EXPECT_EQ(takes[1].frames[0].shutter.open, 0);
  EXPECT_EQ(takes[1].frames[0].shutter.close, 0.5);
  EXPECT_EQ(takes[1].frames[0].shutter.opening, 0.5);
}

TEST(Takes, OrOneOfThemAll) {
  const FrameOptions frames{.numbers = {10, 12, 18}, .rate = 0, .one_structure = true};
  const std::vector<Take> takes = takes_of(frames, {}, {});
  ASSERT_EQ(takes.size(), 1u);
  EXPECT_EQ(takes[0].making.gltf.shutter->begin, 9.75);
  EXPECT_EQ(takes[0].making.gltf.shutter->end, 18.25);
  EXPECT_TRUE(takes[0].making.gltf.at_keys);
  ASSERT_EQ(takes[0].frames.size(), 3u);
  EXPECT_EQ(takes[0].frames[0].shutter.open, 0);
  EXPECT_EQ(takes[0].frames[1].shutter.open, 2 / 8.5);
  EXPECT_EQ(takes[0].frames[1].shutter.close, 2.5 / 8.5);
  EXPECT_EQ(takes[0].frames[2].shutter.close, 1);
}

TEST(Takes, AShutterThatDoesNotStayOpenSeesOneMoment) {
  MakingOptions making;
  making.gltf.shutter = FilePart{0.5, 0.5};
  const std::vector<Take> takes = takes_of({.numbers = {3}}, making, {});
  EXPECT_EQ(takes[0].making.gltf.shutter->begin, 3.5);
  EXPECT_LT(3.5, takes[0].making.gltf.shutter->end);
  EXPECT_EQ(takes[0].frames[0].shutter.open, 0);
  EXPECT_EQ(takes[0].frames[0].shutter.close, 0);
}

TEST(Takes, WithoutFramesAreTheScene) {
  MakingOptions making;
  making.gltf.shutter = FilePart{1, 2};
  const std::vector<Take> takes = takes_of({}, making, {.open = 0.25, .close = 0.75});
  ASSERT_EQ(takes.size(), 1u);
  EXPECT_FALSE(takes[0].making.gltf.shutter->is_in_frames);
  ASSERT_EQ(takes[0].frames.size(), 1u);
  EXPECT_FALSE(takes[0].frames[0].number);
  EXPECT_EQ(takes[0].frames[0].shutter.open, 0.25);
}

/// A square that slides along x, one unit a second, without a camera.
class ShotFrames : public AnimatedGltfTest {
 protected:
  void SetUp() override { file_ = write("slide.glb", sliding({0, 2}, {0, 2}).bytes()); }

  std::string render(const std::string& frames) const {
    return "render --scenes " + file_.string() + " --size 64x36 --spp 2 --frames " + frames;
  }
  Outcome run(const std::string& arguments) const {
    Outcome outcome = stbvh_ab(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
    return outcome;
  }
  LayeredImage frame(const std::string& made, const std::string& number) const {
    return read_exr(folder / made / ("slide-stbvh." + number + ".exr"));
  }
  static void expect_same_pixels(const LayeredImage& a, const LayeredImage& b) {
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (std::size_t i = 0; i < a.channels.size(); ++i)
      EXPECT_EQ(a.channels[i].values, b.channels[i].values) << a.channels[i].name;
  }
  /// Of the pixels that show something.
  static double middle_column(const LayeredImage& image) {
    const std::vector<float>& depth = *image.find("depth.Z");
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      if (!(depth[i] > 0)) continue;
      sum += static_cast<double>(i % image.width);
      ++count;
    }
    EXPECT_GT(count, 0);
    return sum / count;
  }

  fs::path file_;
};

TEST_F(ShotFrames, AreSecondsOfTheFile) {
  const auto first_x = [&](const FilePart& part) {
    return load_gltf(file_, {.clip = "", .shutter = part, .steps = 2}).meshes.at(0).steps[0][0].x;
  };
  EXPECT_EQ(first_x({12, 24, true, 0}), first_x({0.5, 1}));
  EXPECT_EQ(first_x({12, 24, true, 12}), first_x({1, 2}));
  EXPECT_NE(first_x({12, 24, true, 12}), first_x({0.5, 1}));
}

TEST_F(ShotFrames, DependOnThemselvesAlone) {
  run(render("4-6") + " -o " + at("all"));
  run(render("5") + " -o " + at("alone"));
  expect_same_pixels(frame("all", "0005"), frame("alone", "0005"));
  EXPECT_NE(*frame("all", "0004").find("R"), *frame("all", "0005").find("R"));
}

TEST_F(ShotFrames, InTilesAreTheSameBits) {
  run(render("5") + " -o " + at("whole"));
  for (const char* const tile : {"1/2", "2/2"}) run(render("5") + " --tile " + tile + " -o " + at("tiles"));
  const std::string tile = at("tiles") + "/slide-stbvh.0005.";
  run("merge " + tile + "1of2.exr " + tile + "2of2.exr -o " + at("tiles") + "/slide-stbvh.0005.exr");
  expect_same_pixels(frame("tiles", "0005"), frame("whole", "0005"));
}

TEST_F(ShotFrames, ThroughOneStructureShowTheSame) {
  run(render("1,24,47") + " -o " + at("each"));
  run(render("1,24,47") + " --one-structure -o " + at("one"));
  for (const char* const number : {"0001", "0024", "0047"}) {
    const LayeredImage a = frame("each", number), b = frame("one", number);
    std::size_t far_off = 0;
    for (std::size_t i = 0; i < a.width * a.height; ++i)
      far_off += std::abs((*a.find("G"))[i] - (*b.find("G"))[i]) > 1e-3f ? 1u : 0u;
    EXPECT_LE(far_off, 5u) << number;  // rays beside an edge, whose times are rounded otherwise
  }
}

TEST_F(ShotFrames, AreSeenFromOnePlaceWhereAFileHasNoCamera) {
  run(render("0,48") + " --shutter 0,0 -o " + at("all"));
  run(render("48") + " --shutter 0,0 -o " + at("alone"));
  EXPECT_GT(middle_column(frame("all", "0048")), middle_column(frame("all", "0000")) + 20);
  expect_same_pixels(frame("all", "0048"), frame("alone", "0048"));
}

TEST_F(ShotFrames, AreTakenUp) {
  const std::string command = render("1-3") + " --resume -o " + at("all");
  run(command);
  const auto file = [&](const char* number) {
    return folder / "all" / ("slide-stbvh." + std::string(number) + ".exr");
  };
  const std::string first = read_file(file("0001"));
  fs::resize_file(file("0002"), 100);
  fs::remove(file("0003"));
  EXPECT_NE(run(command).out.find("3 frames, 1 finished before"), std::string::npos);
  EXPECT_EQ(read_file(file("0001")), first);
  EXPECT_EQ(read_exr(file("0002")).width, 64u);
  EXPECT_NE(run(command).out.find("3 frames, 3 finished before"), std::string::npos);
  // The same numbers at other times of the file are other pictures.
  EXPECT_EQ(run(command + " --fps 12").out.find("finished before"), std::string::npos);
}

/// Hidden in the second half of the first second.
Document blinking() {
  Document d;
  d.root["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = true;
  const int times = d.add<float>("SCALAR", 5126, {0, 0.5f, 1});
  const int visible = d.add<std::uint8_t>("SCALAR", 5121, {1, 0, 1});
  d.root["animations"][0]["samplers"][0] = {{"input", times}, {"output", visible}, {"interpolation", "STEP"}};
  d.root["animations"][0]["channels"][0] = {
      {"sampler", 0},
      {"target",
       {{"path", "pointer"},
        {"extensions",
         {{"KHR_animation_pointer", {{"pointer", "/nodes/0/extensions/KHR_node_visibility/visible"}}}}}}}};
  return d;
}

TEST_F(ShotFrames, MayBeEmpty) {
  write("slide.glb", blinking().bytes());
  const auto covered = [&](const char* number) {
    const std::vector<float> depth = *frame("made", number).find("depth.Z");
    return std::ranges::count_if(depth, [](float z) { return z > 0; });
  };
  for (const char* const steps : {"", " --steps keys", " --steps auto:1e-3", " --one-structure"}) {
    const std::string command = render("11,18,25") + steps + " --max-bytes 200% -o " + at("made");
    const bool is_apart = std::string(steps) != " --one-structure";
    EXPECT_EQ(run(command).out.find(", 1 without a mesh") != std::string::npos, is_apart) << steps;
    EXPECT_GT(covered("0011"), 0) << steps;
    EXPECT_EQ(covered("0018"), 0) << steps;
    EXPECT_GT(covered("0025"), 0) << steps;
  }
  run(render("18") + " --structures all -o " + at("made"));
  for (const std::string_view structure : structure_names()) {
    const LayeredImage image = read_exr(folder / "made" / fmt::format("slide-{}.0018.exr", structure));
    for (const char* const channel : {"R", "G", "B"})
      EXPECT_EQ(*image.find(channel), *frame("made", "0018").find(channel)) << structure;
  }
}

/// Stands in for ffmpeg: that is a large package.
TEST_F(ShotFrames, AreAFilm) {
  fs::create_directory(folder / "bin");
  const std::string program =
      write("bin/ffmpeg",
            "#!/bin/sh\nwhile [ $# -gt 1 ]; do [ \"$1\" != -i ] || from=$2; shift; done\n"
            "exec cat \"$from\" >\"$1\"\n")
          .string();
  fs::permissions(program, fs::perms::owner_all);
  const std::string in_path = "PATH=" + at("bin") + ":$PATH ";
  const Outcome made =
      run_command(in_path + STBVH_AB + " " + render("1-3") + " --png -o " + at("all") + " 2>&1");
  EXPECT_EQ(made.exit_code, 0) << made.out;
  std::string pictures;
  for (const char* const number : {"1", "2", "3"})
    pictures += read_file(folder / "all" / ("slide-stbvh.000" + std::string(number) + ".png"));
  EXPECT_EQ(read_file(folder / "all/slide-stbvh.mp4"), pictures);

  write("bin/ffmpeg", "#!/bin/sh\nexit 1\n");
  const Outcome failed =
      run_command(in_path + STBVH_AB + " " + render("1-3") + " --png --resume -o " + at("all") + " 2>&1");
  EXPECT_EQ(failed.exit_code, 1) << failed.out;
  EXPECT_NE(failed.out.find("ffmpeg failed"), std::string::npos) << failed.out;
}

TEST_F(ShotFrames, ThatCannotBeAreRefused) {
  expect_refusal(stbvh_ab("render --scenes wheels --frames 1-2 -o " + at("a")), "\"wheels\" has no frames");
  expect_refusal(stbvh_ab(render("1-2:0") + " -o " + at("a")), "--frames takes numbers");
  expect_refusal(stbvh_ab(render("1-2") + " --fps 0 -o " + at("a")), "--fps must be above 0");
  expect_refusal(stbvh_ab(render("1-2") + " --shutter 0.5,0 -o " + at("a")), "--shutter must be A,B");
  expect_refusal(stbvh_ab("render --scenes wheels --one-structure -o " + at("a")), "--frames");
  EXPECT_FALSE(fs::exists(folder / "a"));
  // What cannot be written is known before the first is rendered.
  for (const char* const name : {"slide-stbvh.0003.exr", "slide-stbvh.0003.png", "slide-stbvh.mp4"}) {
    const fs::path in_the_way = folder / "b" / name;
    fs::create_directories(in_the_way);
    expect_refusal(stbvh_ab(render("1-3") + " --png -o " + at("b")), "Cannot write to");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "b"), {}), 1) << name;
    fs::remove(in_the_way);
  }
  expect_refusal(run_command("TMPDIR=" + at("none") + " " STBVH_AB " " + render("1-3") + " --png -o " +
                             at("b") + " 2>&1"),
                 "none\" (TMPDIR): No such file");
  EXPECT_TRUE(fs::is_empty(folder / "b"));
}

}  // namespace
}  // namespace stbvh::harness
