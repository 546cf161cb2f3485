/// The preview's model with its threads: opening, building, cancelling, saving.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include "harness/images/exr_file.h"
#include "harness/preview/preview_model.h"
#include "harness/program/usage_error.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

class PreviewModelTest : public ::testing::Test {
 protected:
  static ModelOptions options(double scale = 0.01) {
    ModelOptions o;
    o.scale = scale;
    o.scene_words = {"--scale", std::to_string(scale)};
    o.threads = 2;
    o.structures = {"stbvh-direct", "embree"};
    return o;
  }

  /// Lives as a window would let it, until `is_done`; false where that never comes.
  template <typename IsDone>
  static bool live(PreviewModel& model, const IsDone& is_done) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::seconds(120)) {
      model.update(0.01, 80, 50);
      model.view();
      if (is_done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  static bool wait(PreviewModel& model, std::size_t samples) {
    return live(model, [&] { return model.has_samples(samples); });
  }
  static bool wait_idle(PreviewModel& model) {
    return live(model, [&] { return !model.load_progress().is_busy; });
  }
  /// Whether a build was under way when it was cancelled: on a busy machine it may have ended.
  static bool cancels_build(PreviewModel& model) {
    model.open("wheels");
    EXPECT_TRUE(live(model, [&] {
      const LoadProgress p = model.load_progress();
      return !p.is_busy || (p.stage.find("building") != std::string::npos && p.fraction > 0);
    }));
    model.cancel();
    EXPECT_TRUE(wait_idle(model));
    return model.message() == "Cancelled." && !model.state().structures[0];
  }

  const TemporaryFolder owner_;
  const fs::path& folder_ = owner_.path();
};

TEST_F(PreviewModelTest, ShowsASceneThroughTwoStructures) {
  PreviewModel model(options(), 4);
  EXPECT_TRUE(model.view().image.rgb.empty());
  model.open("wheels");
  ASSERT_TRUE(wait(model, 4));
  EXPECT_EQ(model.message(), "");
  EXPECT_EQ(model.view().image.width, 80u);
  ASSERT_TRUE(model.state().structures[1]);
  EXPECT_EQ(model.state().structures[1]->name, "embree");
  EXPECT_EQ(model.state().figures.compared, 4u * 80 * 50);
  EXPECT_EQ(model.state().figures.leaks[0], 0u);
  EXPECT_EQ(model.load_progress().builds, 2u);
}

TEST_F(PreviewModelTest, PlaysAllFramesThroughOneStructure) {
  PreviewModel model(options(), 4);
  model.open("static-city");
  ASSERT_TRUE(wait(model, 1));
  model.animation.is_playing = true;
  model.animation.frames = 8;
  model.animation.seconds = 0.4;
  const std::uint64_t first = model.state().picture_number;
  EXPECT_TRUE(
      live(model, [&] { return model.frames_played() > 16 && model.state().picture_number > first + 3; }));
  EXPECT_EQ(model.load_progress().builds, 2u) << "nothing is built again";
}

TEST_F(PreviewModelTest, WhatCannotBeOpenedLeavesTheLastScene) {
  std::ofstream(folder_ / "broken.glb") << "glTF, but no more of it";
  std::ofstream(folder_ / "broken.xml") << "<scene><Triangle";
  PreviewModel model(options(), 2);
  model.open("wheels");
  ASSERT_TRUE(wait(model, 2));
  for (const char* name : {"broken.glb", "broken.xml", "missing.glb", "text.txt"}) {
    model.open((folder_ / name).string());
    ASSERT_TRUE(wait_idle(model));
    EXPECT_NE(model.message(), "") << name;
    EXPECT_EQ(model.message().find('\n'), std::string::npos) << name;
    EXPECT_EQ(model.state().structures[0]->scene->name, "wheels");
    EXPECT_TRUE(wait(model, 2));
  }
  model.open("static-city");
  ASSERT_TRUE(wait(model, 2));
  EXPECT_EQ(model.message(), "");
  EXPECT_EQ(model.state().structures[0]->scene->name, "static-city");
}

TEST_F(PreviewModelTest, StructuresAreChangedOneByOne) {
  PreviewModel model(options(), 2);
  model.open("wheels");
  ASSERT_TRUE(wait(model, 2));
  const BuiltStructurePtr a = model.state().structures[0];
  model.choose_structure(1, "lbvh");
  ASSERT_TRUE(wait(model, 2));
  EXPECT_EQ(model.state().structures[0], a) << "it is not built again";
  EXPECT_EQ(model.state().structures[1]->name, "lbvh");
  model.choose_structure(1, "");
  ASSERT_TRUE(wait(model, 2));
  EXPECT_FALSE(model.state().structures[1]);
  EXPECT_THROW(model.choose_structure(0, "stbhv"), UsageError);
  EXPECT_THROW(model.choose_structure(0, ""), UsageError);
  model.choose_structure(0, "embree");
  ASSERT_TRUE(wait(model, 2));
  EXPECT_EQ(model.tree(), nullptr);
}

TEST_F(PreviewModelTest, CancelsABuildOfEachKind) {
  for (const char* name : {"stbvh-direct", "stbvh", "embree", "lbvh"}) {
    ModelOptions o = options(1);
    o.structures = {name};
    bool is_cancelled = false;
    for (int attempt = 0; attempt < 20 && !is_cancelled; ++attempt) {
      PreviewModel model(o, 2);
      is_cancelled = cancels_build(model);
    }
    EXPECT_TRUE(is_cancelled) << name;
  }
}

/// Many seconds to make, of each kind: bodies, cloth, fur, machines.
constexpr std::array<const char*, 6> kSlowScenes{"dancer", "cloth", "llama", "crowd", "barbarian", "train"};
constexpr double kSlowScale = 8;
/// Cancelling takes milliseconds; the rest is for machines that are busy.
constexpr std::chrono::seconds kSoon{5};

TEST_F(PreviewModelTest, CancelsTheMakingOfAScene) {
  for (const char* name : kSlowScenes) {
    PreviewModel model(options(kSlowScale), 2);
    model.open(name);
    ASSERT_TRUE(live(model, [&] { return model.load_progress().stage.find("making") != std::string::npos; }))
        << name;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const auto start = std::chrono::steady_clock::now();
    model.cancel();
    ASSERT_TRUE(wait_idle(model));
    EXPECT_LT(std::chrono::steady_clock::now() - start, kSoon) << name;
    EXPECT_EQ(model.message(), "Cancelled.") << name;
    EXPECT_EQ(model.load_progress().builds, 0u);
  }
}

TEST_F(PreviewModelTest, CancelsWhatWasNotBegunYet) {
  PreviewModel model(options(), 2);
  for (std::size_t i = 1; i <= 50; ++i) {
    model.open("wheels");
    model.cancel();
    ASSERT_TRUE(wait_idle(model)) << i;
    EXPECT_EQ(model.load_progress().ended, i);
    EXPECT_EQ(model.message(), "Cancelled.");
  }
}

TEST_F(PreviewModelTest, AFileThatIsDroppedDoesNotWaitForTheSceneThatIsBeingMade) {
  PreviewModel model(options(kSlowScale), 1);
  model.open("dancer");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto start = std::chrono::steady_clock::now();
  model.open(STBVH_SOURCE_DIR "/data/bending_tube.glb");
  ASSERT_TRUE(wait(model, 1));
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2 * kSoon);
  EXPECT_EQ(model.state().structures[0]->scene->name, "bending_tube");
  EXPECT_EQ(model.message(), "");
}

TEST_F(PreviewModelTest, EndsWhileASceneIsBeingMade) {
  std::optional<PreviewModel> model;
  model.emplace(options(kSlowScale), 2);
  model->open("dancer");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto start = std::chrono::steady_clock::now();
  model.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, kSoon);
}

TEST_F(PreviewModelTest, ShowsAWhileBIsBeingBuilt) {
  ModelOptions o = options(0.3);
  o.structures = {"embree", "lbvh"};
  bool was_shown = false;
  for (int attempt = 0; attempt < 10 && !was_shown; ++attempt) {  // a busy machine may not look in time
    std::atomic<std::size_t> news{0};
    PreviewModel model(o, 2, [&] { ++news; });
    model.open("wheels");
    ASSERT_TRUE(live(model, [&] {
      const bool is_waiting_for_b = model.is_building(1) && !model.state().structures[1];
      was_shown = was_shown || (is_waiting_for_b && model.view().number > 0);
      return model.has_samples(2);
    }));
    EXPECT_FALSE(model.is_building(0));
    EXPECT_FALSE(model.is_building(1));
    EXPECT_GE(news, 4u) << "two structures, and a picture with each";
  }
  EXPECT_TRUE(was_shown) << "the picture through A is there before B is";
}

TEST_F(PreviewModelTest, EndsWhileBuildingAndWhileOpeningAgainAndAgain) {
  for (int i = 0; i < 5; ++i) {
    PreviewModel model(options(0.05), 2);
    for (const char* name : {"static-city", "wheels", "static-city"}) {
      model.open(name);
      model.update(0.01, 33, 17);
      std::this_thread::sleep_for(std::chrono::milliseconds(3 * i));
    }
  }
}

TEST_F(PreviewModelTest, SavesWhatItsCommandMakesAgain) {
  PreviewModel model(options(), 3);
  model.open("wheels");
  ASSERT_TRUE(wait(model, 1));
  model.camera.orbit(25, 10);
  model.camera.dolly(0.8);
  model.animation.is_whole = false;
  model.animation.scrub(0.3);
  model.lens_radius = 0.01;
  ASSERT_TRUE(wait(model, 3));
  model.save(folder_ / "view");
  ASSERT_TRUE(live(model, [&] { return !model.is_saving(); }));
  EXPECT_NE(model.message().find("Saved"), std::string::npos) << model.message();
  EXPECT_GT(fs::file_size(folder_ / "view.png"), 100u);
  std::string command = model.command_line();
  ASSERT_TRUE(command.starts_with("stbvh-ab render ")) << command;
  command = command.substr(9, command.find(" -o ") - 9) + " -o " + (folder_ / "again").string();
  const Outcome run = stbvh_ab(command);
  ASSERT_EQ(run.exit_code, 0) << run.out;
  for (const auto& [mine, theirs] :
       {std::pair{"view.exr", "wheels-stbvh-direct.exr"}, std::pair{"view-b.exr", "wheels-embree.exr"}}) {
    const LayeredImage saved = read_exr(folder_ / mine), again = read_exr(folder_ / "again" / theirs);
    ASSERT_EQ(saved.channels.size(), again.channels.size());
    for (const Channel& channel : saved.channels) {
      ASSERT_NE(again.find(channel.name), nullptr);
      EXPECT_EQ(channel.values, *again.find(channel.name)) << channel.name;
    }
  }
}

TEST_F(PreviewModelTest, SaysWhereItCannotSave) {
  PreviewModel model(options(), 1);
  model.save(folder_ / "early");
  EXPECT_NE(model.message(), "");
  model.open("wheels");
  ASSERT_TRUE(wait(model, 1));
  model.save("/nowhere/at/all");
  EXPECT_NE(model.message().find("/nowhere"), std::string::npos) << model.message();
  EXPECT_FALSE(model.is_saving());
}

TEST_F(PreviewModelTest, FocusesAndPicksWhatIsUnderThePointer) {
  PreviewModel model(options(), 1);
  EXPECT_FALSE(model.focus(0.5, 0.5));
  model.open("static-city");
  ASSERT_TRUE(wait(model, 1));
  const Camera before = model.camera.camera();
  ASSERT_TRUE(model.focus(0.5, 0.6));
  const Camera after = model.camera.camera();
  EXPECT_EQ(before.position.x, after.position.x);
  ASSERT_TRUE(model.pick_subtree(0.5, 0.6));
  model.tree_options.subtree_level = 2;
  const TimeLine line = model.time_line();
  EXPECT_FALSE(line.nodes.empty());
  model.tree_options.subtree_level = 0;
  EXPECT_GT(model.time_line().nodes.size(), 0u);
}

}  // namespace
}  // namespace stbvh::harness
