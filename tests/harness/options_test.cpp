/// What command lines are read as.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "harness/cli/render_options.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/usage_error.h"
#include "harness/program/whole_numbers.h"
#include "harness/scenes/procedural/procedural.h"

namespace stbvh::harness {
namespace {

template <class Options = BenchOptions>
Options parse(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"stbvh-ab"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  Options options;
  CLI::App app;
  add_options(*app.add_subcommand(arguments.front(), ""), options);
  EXPECT_TRUE(parse_command_line(app, static_cast<int>(argv.size()), argv.data()));
  return options;
}

std::vector<std::string> names_of(std::span<const ProceduralScene> scenes) {
  std::vector<std::string> names;
  for (const ProceduralScene& scene : scenes) names.emplace_back(scene.name);
  return names;
}

TEST(SceneOptions, AreThoseOfThePaperUnlessNamed) {
  EXPECT_EQ(parse({"bench"}).scenes, names_of(scene_group("paper")));
  EXPECT_EQ(parse({"error", "--scenes", "paper"}).scenes, names_of(scene_group("paper")));
  EXPECT_EQ(parse({"bench", "--scenes", "all"}).scenes, names_of(procedural_scenes()));
  EXPECT_EQ(parse({"bench", "--scenes", "large,small"}).scenes, names_of(procedural_scenes()));
  EXPECT_EQ(parse({"bench", "--scenes", "small"}).scenes,
            (std::vector<std::string>{"torus", "walker", "cart"}));
  EXPECT_EQ(parse({"bench", "--scenes", "cloth,my.glb"}).scenes,
            (std::vector<std::string>{"cloth", "my.glb"}));
}

TEST(SceneOptions, NameEachSceneOnce) {
  std::vector<std::string> expected{"crowd", "llama", "barbershop", "train", "barbarian", "barbarian-rotate"};
  EXPECT_EQ(parse({"bench", "--scenes", "crowd,paper,crowd"}).scenes, expected);
}

TEST(GltfOptions, StepsAreANumberOrADeviation) {
  EXPECT_EQ(parse({"bench"}).gltf.steps, 9u);
  EXPECT_FALSE(parse({"bench"}).gltf.largest_deviation.has_value());
  EXPECT_EQ(parse({"bench", "--steps", "129"}).gltf.steps, 129u);
  EXPECT_EQ(parse({"bench", "--steps", "auto:1e-3"}).gltf.largest_deviation, 1e-3);
  EXPECT_EQ(parse({"bench"}).obj_step, 1u);
  EXPECT_EQ(parse({"bench", "--step", "2"}).obj_step, 2u);
  EXPECT_THROW(parse({"bench", "--step", "0"}), UsageError);
  EXPECT_EQ(parse({"bench"}).gltf.shutter_mode, ShutterMode::kClamp);
  EXPECT_EQ(parse({"bench", "--shutter-mode", "loop"}).gltf.shutter_mode, ShutterMode::kLoop);
}

TEST(SceneOptions, AreHandedOnAsTheyWereGiven) {
  EXPECT_TRUE(parse<RenderOptions>({"render", "-o", "page", "--png"}).scene_words.empty());
  const SceneOptions given = parse<RenderOptions>(
      {"render", "-o", "page", "--scenes", "cloth,my.glb", "--scale", "0.5", "--seed=7", "--clip", "-1",
       "--shutter", "0,0.5", "--shutter-mode", "loop", "--steps", "auto:1e-3"});
  std::vector<std::string> words{"bench"};
  words.insert(words.end(), given.scene_words.begin(), given.scene_words.end());
  for (const SceneOptions& o : {given, static_cast<SceneOptions>(parse(words))}) {
    EXPECT_EQ(o.scenes, (std::vector<std::string>{"cloth", "my.glb"}));
    EXPECT_EQ(o.scale, 0.5);
    EXPECT_EQ(o.seed, 7u);
    EXPECT_EQ(o.gltf.clip, "-1");
    ASSERT_TRUE(o.gltf.shutter.has_value());
    EXPECT_EQ(o.gltf.shutter->end, 0.5);
    EXPECT_EQ(o.gltf.shutter_mode, ShutterMode::kLoop);
    EXPECT_EQ(o.gltf.largest_deviation, 1e-3);
  }
}

TEST(SceneOptions, SeedsAreAnyWholeNumber) {
  EXPECT_EQ(parse({"bench"}).seed, 1u);
  EXPECT_EQ(parse({"bench", "--seed", "18446744073709551615"}).seed, std::uint64_t{0} - 1);
  EXPECT_EQ(parse({"bench", "--seed=0"}).seed, 0u);
}

TEST(WholeNumbers, AreDigitsAlone) {
  EXPECT_EQ(parse_whole_number("--count", "007"), 7u);
  for (const char* text : {"", "-1", "+1", " 1", "1 ", "1.0", "1e3", "0x10", "18446744073709551616",
                           "-18446744073709551615", "1'000"})
    EXPECT_THROW(parse_whole_number("--count", text), UsageError) << text;
}

TEST(ThreadOptions, AreAllCoresOrAListOfCounts) {
  EXPECT_EQ(parse({"bench"}).thread_counts, std::vector<unsigned>{usable_core_count()});
  EXPECT_EQ(parse({"bench"}).threads(), usable_core_count());
  EXPECT_EQ(parse({"error", "--threads", "1"}).thread_counts, std::vector<unsigned>{1});
  EXPECT_EQ(parse({"bench", "--threads", "1,1"}).thread_counts, std::vector<unsigned>{1});
  if (usable_core_count() < 2) GTEST_SKIP() << "one core";
  EXPECT_EQ(parse({"bench", "--threads", "2,1"}).thread_counts, (std::vector<unsigned>{1, 2}));
  EXPECT_EQ(parse({"bench", "--threads", "2,1"}).threads(), 2u);
}

}  // namespace
}  // namespace stbvh::harness
