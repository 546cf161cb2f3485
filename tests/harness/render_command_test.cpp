/// The command `render`: what it writes, what it refuses, and what is left when it or `truth` is stopped.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "harness/images/exr_file.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

class RenderCommand : public TemporaryFolderTest {
 protected:
  static std::map<std::string, std::string> metadata(const fs::path& path) {
    const LayeredImage image = read_exr(path);
    return {image.metadata.begin(), image.metadata.end()};
  }

  const std::string base_ = "render --scenes wheels --scale 0.01 --structures stbvh-direct ";
  const std::string small_ = "render --scenes wheels --scale 0.01 --size 40x24 --spp 2 ";
};

TEST_F(RenderCommand, WritesLayersAndMetadata) {
  const Outcome run = stbvh_ab(small_ + "--structures stbvh-direct --png -o " + at("a.exr") +
                               " --seed 7 --shutter-close 0.5 --shutter-curve triangle");
  ASSERT_EQ(run.exit_code, 0) << run.out;
  const LayeredImage image = read_exr(folder / "a.exr");
  EXPECT_EQ(image.width, 40u);
  EXPECT_EQ(image.height, 24u);
  for (const char* name : {"R", "G", "B", "albedo.R", "normal.Z", "depth.Z", "motion.X", "motion.Y", "time.T",
                           "variance.B", "nodes.N", "triangles.N"}) {
    EXPECT_NE(image.find(name), nullptr) << name;
  }
  EXPECT_EQ(image.id_channels.size(), 3u);
  auto of = metadata(folder / "a.exr");
  EXPECT_EQ(of["scene"], "wheels");
  EXPECT_EQ(of["structure"], "stbvh-direct");
  EXPECT_EQ(of["seed"], "7");
  EXPECT_EQ(of["spp"], "2");
  EXPECT_EQ(of["complete"], "yes");
  EXPECT_EQ(of["not_finite"], "0");
  EXPECT_EQ(of["shutter"], "0 to 0.5, opening 0.5, closing 0.5");
  EXPECT_GT(std::stod(of["mrays_per_s"]), 0);
  for (const char* name : {"commit", "machine", "seconds", "size"}) EXPECT_FALSE(of[name].empty()) << name;
  EXPECT_GT(fs::file_size(folder / "a.png"), 100u);
}

TEST_F(RenderCommand, WritesAFileForEachSceneAndStructure) {
  const std::string made = at("new/folder");
  const Outcome run = stbvh_ab(
      "render --scenes wheels,cloth --scale 0.01 --size 8x8 --spp 1 --structures lbvh,embree -o " + made);
  ASSERT_EQ(run.exit_code, 0) << run.out;
  for (const char* name : {"wheels-lbvh", "wheels-embree", "cloth-lbvh", "cloth-embree"}) {
    EXPECT_EQ(metadata(fs::path(made) / (std::string(name) + ".exr"))["complete"], "yes") << name;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(made), {}), 4);
}

TEST_F(RenderCommand, IsLitByAnEnvironment) {
  LayeredImage sky{.width = 4, .height = 2, .channels = {}, .id_channels = {}, .metadata = {}};
  for (const char* name : {"R", "G", "B"}) sky.channels.push_back({name, std::vector<float>(8, 0.25f)});
  write_exr(sky, folder / "sky.exr");
  const std::string command = small_ + "-o " + at("a.exr") + " --environment ";
  ASSERT_EQ(stbvh_ab(command + at("sky.exr")).exit_code, 0);
  const LayeredImage image = read_exr(folder / "a.exr");
  std::size_t misses = 0;
  for (std::size_t i = 0; i < image.width * image.height; ++i) {
    if ((*image.find("albedo.G"))[i] > 0) continue;
    ++misses;
    EXPECT_FLOAT_EQ((*image.find("R"))[i], 0.25f);
  }
  EXPECT_GT(misses, 0u);

  sky.channels[1].values[3] = -1;
  write_exr(sky, folder / "negative.exr");
  sky.channels[1].name = "Y";
  write_exr(sky, folder / "gray.exr");
  for (const char* bad : {"negative.exr", "gray.exr", "missing.exr", "."}) {
    const Outcome run = stbvh_ab(command + at(bad));
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_NE(run.out.find("picture"), std::string::npos) << run.out;
  }
}

TEST_F(RenderCommand, RefusesWhatCannotBe) {
  for (const char* bad : {"",
                          "-o /proc/none/a.exr",
                          "-o /no/such/directory/a.exr",
                          "-o a.png",
                          "-o a.exr --size 0x5",
                          "-o a.exr --size 5",
                          "-o a.exr --size 5x1e9",
                          "-o a.exr --spp 0",
                          "-o a.exr --spp 1000000",
                          "-o a.exr --structures stbhv",
                          "-o a.exr --shutter-open 0.7 --shutter-close 0.3",
                          "-o a.exr --shutter-close 2",
                          "-o a.exr --shutter-open nan",
                          "-o a.exr --shutter-curve sine",
                          "-o a.exr --lens-radius -1",
                          "-o a.exr --fov 180",
                          "-o a.exr --camera-position 1,2",
                          "-o a.exr --camera-target 1,2,nan",
                          "-o a.exr --camera-up=0,0,0",
                          "-o a.exr --camera-up 1,2,3,4",
                          "-o a.exr --camera-position=1,1,1 --camera-target=1,1,1",
                          "-o a.exr --camera-position 1e30,0,0",
                          "-o a.exr --camera-position=0,-1.9e18,0",
                          "-o a.exr --camera-target 1e300,0,0",
                          "-o a.exr --lens-radius 1e30",
                          "-o a.exr --lens-radius inf",
                          "-o a.exr --focus-distance 1e300",
                          "-o a.exr --focus-distance 0",
                          "-o a.exr --threads 0"}) {
    const Outcome run = stbvh_ab(std::string("render --scenes wheels --scale 0.01 ") + bad);
    EXPECT_EQ(run.exit_code, 2) << bad << ": " << run.out;
    EXPECT_NE(run.out.find("stbvh-ab: "), std::string::npos) << run.out;
  }
  EXPECT_FALSE(fs::exists("a.exr"));
}

/// Embree would abort the process on rays from further away than it knows.
TEST_F(RenderCommand, NumbersAtTheLimitsReachNoAssertion) {
  for (const char* const extreme :
       {"--camera-position 1.8e18,0,0", "--camera-position=-1.8e18,1.8e18,1.8e18", "--lens-radius 1.84e18",
        "--camera-position 1e-40,0,0 --camera-target 0,1.8e18,0", "--fov 1e-30", "--fov 179.99999",
        "--focus-distance 1e-300 --lens-radius 1", "--shutter-open 1e-45 --shutter-close 1e-45"}) {
    const Outcome run = stbvh_ab(small_ + extreme + " --structures embree -o " + at("limit.exr"));
    EXPECT_EQ(run.exit_code, 0) << extreme << ": " << run.out;
  }
}

TEST_F(RenderCommand, TakesACameraInsteadOfTheScenes) {
  ASSERT_EQ(stbvh_ab(small_ + "-o " + at("scene.exr")).exit_code, 0);
  ASSERT_EQ(stbvh_ab(small_ + "--fov 10 -o " + at("narrow.exr")).exit_code, 0);
  // Straight up: nothing but the sky, which stays where the scene's own camera puts its sun.
  ASSERT_EQ(
      stbvh_ab(small_ + "--camera-position=0,500,0 --camera-target=0,501,0.1 -o " + at("sky.exr")).exit_code,
      0);
  EXPECT_NE(*read_exr(folder / "scene.exr").find("R"), *read_exr(folder / "narrow.exr").find("R"));
  const LayeredImage sky = read_exr(folder / "sky.exr");
  for (float depth : *sky.find("depth.Z")) EXPECT_EQ(depth, 0);
  EXPECT_NE(metadata(folder / "sky.exr")["camera"].find("position 0,500,0"), std::string::npos);
}

TEST_F(RenderCommand, ReportsAFullDisk) {
  if (!make_device("full", Device::kFull)) GTEST_SKIP() << "only root may make device nodes";
  const Outcome run = stbvh_ab(small_ + "-o " + at("full"));
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_NE(run.out.find("Cannot write to \"" + at("full") + "\""), std::string::npos) << run.out;
}

TEST_F(RenderCommand, KeepsFinishedTilesWhenInterrupted) {
  // Minutes of work, interrupted after the first seconds.
  const std::string file = at("a.exr");
  const std::string command = "timeout --foreground --preserve-status -s INT 3 " + std::string(STBVH_AB) +
                              " render --scenes wheels --scale 0.01 --size 2000x1200 --spp 256 -o " + file +
                              " 2>" + at("log");
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(metadata(file)["complete"], "no");
  double sum = 0;
  const LayeredImage image = read_exr(file);
  for (float value : *image.find("R")) sum += static_cast<double>(value);
  EXPECT_GT(sum, 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2) << "a.exr and the log";
}

/// Runs `truth`, interrupted half a second after the shell condition `begun` holds; killed if that does
/// nothing. (Without --foreground, `timeout` sends each signal twice, and the second ends the program.)
Outcome interrupted_truth(const std::string& arguments, const std::string& log, const std::string& begun) {
  const std::string command = "timeout --foreground -s KILL 100 " STBVH_AB
                              " truth --scenes wheels --scale 0.01 " +
                              arguments + " >" + log + " 2>&1 & until " + begun +
                              "; do kill -0 $! || break; sleep 0.1; done; sleep 0.5; kill -INT $!; wait $!";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(log)};
}

TEST_F(RenderCommand, TruthStopsAtFrozenTimesWhenInterrupted) {
  const std::string log = at("log"), out = at("out");
  const Outcome run = interrupted_truth("--size 32x18 --frozen-times 1000000 -o " + out, log,
                                        "grep -q triangles " + log);  // the scene is made
  EXPECT_EQ(run.exit_code, 130) << run.out;
  EXPECT_NE(run.out.find("stbvh-ab: Interrupted after "), std::string::npos) << run.out;
  EXPECT_NE(run.out.find(" of 1000000 frozen times: nothing is written."), std::string::npos) << run.out;
  EXPECT_TRUE(fs::is_empty(out));
}

TEST_F(RenderCommand, TruthStopsAtMotionWhenInterrupted) {
  const std::string log = at("log"), out = at("out");
  const Outcome run = interrupted_truth("--size 200x120 --frozen-times 1 --spp 65536 -o " + out, log,
                                        "test -e " + out + "/frozen-times.png");
  EXPECT_EQ(run.exit_code, 130) << run.out;
  EXPECT_NE(run.out.find(" samples per pixel: only the pictures of frozen times"), std::string::npos)
      << run.out;
  EXPECT_EQ(std::distance(fs::directory_iterator(out), {}), 2) << "the .exr and .png of frozen times";
}

/// Three tiles of a picture whose rows three does not divide.
class TiledPicture : public RenderCommand {
 protected:
  void SetUp() override {
    for (const char* const i : {"1", "2", "3"}) {
      const Outcome run = stbvh_ab(base_ + "--size 40x25 --spp 2 --tile " + i + "/3 -o " + tile(i));
      ASSERT_EQ(run.exit_code, 0) << run.out;
    }
  }
  std::string tile(const char* i) const { return at("tile-" + std::string(i) + ".exr"); }
  Outcome merge(const std::string& tiles) const {
    return stbvh_ab("merge " + tiles + " -o " + at("merged.exr"));
  }
  void expect_no_merge(const std::string& tiles, const std::string& reason) const {
    const Outcome run = merge(tiles);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_NE(run.out.find("stbvh-ab: "), std::string::npos) << run.out;
    EXPECT_NE(run.out.find(reason), std::string::npos) << run.out;
    EXPECT_FALSE(fs::exists(folder / "merged.exr"));
  }
};

TEST_F(TiledPicture, IsTheSameBitsAsOneProcess) {
  ASSERT_EQ(merge(tile("3") + " " + tile("1") + " " + tile("2")).exit_code, 0);
  ASSERT_EQ(stbvh_ab(base_ + "--size 40x25 --spp 2 -o " + at("whole.exr")).exit_code, 0);
  const LayeredImage middle = read_exr(tile("2"));
  EXPECT_EQ(middle.top, 8);
  EXPECT_EQ(middle.height, 8u);
  EXPECT_EQ(middle.display_window(), (PixelWindow{0, 0, 40, 25}));
  const LayeredImage merged = read_exr(folder / "merged.exr"), whole = read_exr(folder / "whole.exr");
  EXPECT_EQ(merged.window(), whole.window());
  ASSERT_EQ(merged.channels.size(), whole.channels.size());
  for (std::size_t i = 0; i < whole.channels.size(); ++i) {
    EXPECT_EQ(merged.channels[i].name, whole.channels[i].name);
    EXPECT_EQ(bytes_of(merged.channels[i].values), bytes_of(whole.channels[i].values))
        << whole.channels[i].name;
  }
  ASSERT_EQ(merged.id_channels.size(), whole.id_channels.size());
  for (std::size_t i = 0; i < whole.id_channels.size(); ++i)
    EXPECT_EQ(merged.id_channels[i].values, whole.id_channels[i].values);
  auto of_merged = metadata(folder / "merged.exr"), of_whole = metadata(folder / "whole.exr");
  for (const char* const name : {"scene", "scene_hash", "seed", "spp", "commit", "complete", "strip", "rays"})
    EXPECT_EQ(of_merged[name], of_whole[name]) << name;
}

TEST_F(TiledPicture, IsRefusedUnlessItsTilesAreAllOfIt) {
  expect_no_merge(tile("1") + " " + tile("3"), "Rows 8 to 15 are in none of the tiles.");
  expect_no_merge(tile("1") + " " + tile("2"), "Rows 16 to 24 are in none of the tiles.");
  expect_no_merge(tile("1") + " " + tile("2") + " " + tile("2") + " " + tile("3"),
                  "rows that another tile has too");
  const std::string others = tile("1") + " " + tile("2") + " " + at("other.exr");
  const std::string other = base_ + "--size 40x25 --tile 3/3 -o " + at("other.exr") + " --spp ";
  ASSERT_EQ(stbvh_ab(other + "3").exit_code, 0);
  expect_no_merge(others, "spp is \"2\" and \"3\"");
  ASSERT_EQ(stbvh_ab(other + "2 --seed 9").exit_code, 0);
  expect_no_merge(others, "scene_hash is ");
  LayeredImage stopped = read_exr(tile("3"));
  for (auto& [name, value] : stopped.metadata) {
    if (name == "complete") value = "no";
  }
  write_exr(stopped, folder / "other.exr");
  expect_no_merge(others, "is not complete");
  stopped.metadata.clear();
  write_exr(stopped, folder / "other.exr");
  expect_no_merge(others, "is no tile of stbvh-ab render");
  fs::resize_file(tile("3"), fs::file_size(tile("3")) / 2);
  expect_no_merge(tile("1") + " " + tile("2") + " " + tile("3"), "Cannot read the picture");
}

TEST_F(RenderCommand, RefusesTilesThatAreNone) {
  for (const char* const text : {"0/3", "4/3", "2", "a/b", "1/3x", "1/99999", "-1/3"}) {
    const Outcome run = stbvh_ab(small_ + "-o " + at("a.exr") + " --tile=" + text);
    EXPECT_EQ(run.exit_code, 2) << text;
    EXPECT_NE(run.out.find("--tile"), std::string::npos) << run.out;
  }
  expect_refusal(stbvh_ab(small_ + "-o " + at("a.exr") + " --tile 1/25"),
                 "a picture of 24 rows has no 25 tiles");
}

TEST_F(RenderCommand, ResumesWhatIsNotFinished) {
  const std::string command = base_ + "--size 40x24 --resume -o " + at("a.exr") + " --spp ";
  const auto made = [&](const std::string& samples) {
    const Outcome run = stbvh_ab(command + samples);
    EXPECT_EQ(run.exit_code, 0) << run.out;
    return run.out;
  };
  EXPECT_EQ(made("2").find("finished before"), std::string::npos);
  const std::string bytes = read_file(folder / "a.exr");
  EXPECT_NE(made("2").find("finished before"), std::string::npos);
  EXPECT_EQ(read_file(folder / "a.exr"), bytes);
  EXPECT_NE(made("3").find("its spp was another"), std::string::npos);
  EXPECT_NE(made("2").find("its spp was another"), std::string::npos);
  LayeredImage stopped = read_exr(folder / "a.exr");
  for (auto& [name, value] : stopped.metadata) {
    if (name == "complete") value = "no";
  }
  write_exr(stopped, folder / "a.exr");
  EXPECT_NE(made("2").find("its complete was another"), std::string::npos);
  fs::resize_file(folder / "a.exr", 1000);
  EXPECT_NE(made("2").find("cannot be read"), std::string::npos);
  EXPECT_EQ(metadata(folder / "a.exr")["complete"], "yes");
}

}  // namespace
}  // namespace stbvh::harness
