/// stbvh-preview as a user runs it, in a window on an X server without a screen (Xvfb), driven by scripts.
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "harness/images/image.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"
#include "tests/harness/x_server.h"

namespace stbvh::harness {
namespace {

Image read_png(const fs::path& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  Image image;
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) return image;
  png.format = PNG_FORMAT_RGB;
  image.width = png.width;
  image.height = png.height;
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr);
  return image;
}

using Color = std::array<int, 3>;

Color at(const Image& image, std::size_t x, std::size_t y) {
  const std::uint8_t* p = &image.rgb[3 * (y * image.width + x)];
  return {p[0], p[1], p[2]};
}

/// Of the columns from `first` on to `last`, which is not among them.
std::set<Color> colors(const Image& image, std::size_t first, std::size_t last) {
  std::set<Color> found;
  for (std::size_t y = 0; y < image.height; ++y) {
    for (std::size_t x = first; x < last; ++x) found.insert(at(image, x, y));
  }
  return found;
}
std::set<Color> colors(const Image& image) {
  return colors(image, 0, image.width);
}

class PreviewWindow : public ::testing::Test {
 protected:
  void SetUp() override {
    if (server_.display().empty()) GTEST_SKIP() << "there is no Xvfb (Debian: xvfb): no window is tested";
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Runs the program on `display` with `arguments`.
  Outcome preview(const std::string& arguments, const std::string& environment = "") const {
    const std::string command = "export DISPLAY=" + server_.display() + "; env " + environment +
                                preview_environment() + " " STBVH_PREVIEW " " + arguments + " 2>&1";
    return run_command(command);
  }

  /// Runs `script`, in which @ stands for the test's folder, on the scene wheels.
  Outcome run(std::string script, const std::string& arguments = "--structures stbvh-direct,embree") const {
    for (std::size_t i = 0; (i = script.find('@', i)) != std::string::npos;)
      script.replace(i, 1, folder_.string() + "/");
    std::ofstream(folder_ / "script") << script;
    return preview("wheels --scale 0.01 --samples 2 --size 320x200 --script " + path("script") + " " +
                   arguments);
  }
  /// What run() says, and the exit code where that is not 0; so a test that fails shows why.
  std::string failure(const std::string& script) const {
    const Outcome outcome = run(script);
    return outcome.exit_code == 0 ? "" : std::to_string(outcome.exit_code) + ": " + outcome.out;
  }
  Image shot(const char* name) const { return read_png(folder_ / name); }

  const TemporaryFolder owner_;
  const fs::path& folder_ = owner_.path();
  const XServer server_;
};

TEST_F(PreviewWindow, ShowsASceneThatIsOrbitedAndScrubbed) {
  const Outcome outcome =
      run("panels off\nview a\nwait 2\nscreenshot @a.png\n"
          "orbit 40 10\nwait 2\nscreenshot @orbited.png\norbit -40 0\norbit 0 -10\nwait 2\n"
          "shutter frozen\nscrub 0.1\nwait 2\nscreenshot @early.png\nscrub 0.6\nwait 2\nscreenshot "
          "@late.png\nclose\n");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out;
  const Image a = shot("a.png"), orbited = shot("orbited.png"), early = shot("early.png"),
              late = shot("late.png");
  EXPECT_EQ(a.width, 320u);
  EXPECT_EQ(a.height, 200u);
  EXPECT_GT(colors(a).size(), 200u);
  EXPECT_NE(a.rgb, orbited.rgb);
  EXPECT_NE(early.rgb, late.rgb);
  EXPECT_GT(colors(late).size(), 200u);
}

TEST_F(PreviewWindow, ShowsWhatTheCommandLineRenders) {
  ASSERT_EQ(failure("panels off\nview a\norbit 20 5\nwait 2\nscreenshot @a.png\ncommand @command\nclose\n"),
            "");
  std::string command;
  std::getline(std::ifstream(folder_ / "command"), command);
  ASSERT_TRUE(command.starts_with("stbvh-ab render")) << command;
  command = command.substr(9, command.find(" -o ") - 9) + " --png -o " + path("again");
  ASSERT_EQ(stbvh_ab(command).exit_code, 0);
  const Image a = shot("a.png"), again = read_png(folder_ / "again" / "wheels-stbvh-direct.png");
  ASSERT_EQ(a.rgb.size(), again.rgb.size());
  for (std::size_t i = 0; i < a.rgb.size(); ++i) ASSERT_NEAR(a.rgb[i], again.rgb[i], 1) << i;
}

TEST_F(PreviewWindow, EqualStructuresDifferInNothing) {
  ASSERT_EQ(
      failure(
          "panels off\nstructure b stbvh-direct\nview difference\ngain 10000\nwait 2\nscreenshot @same.png\n"
          "structure b stbvh-direct-fast\nview a\nwait 2\nscreenshot @a.png\nclose\n"),
      "");
  EXPECT_EQ(colors(shot("same.png")), (std::set<Color>{{0, 0, 0}}));
  EXPECT_GT(colors(shot("a.png")).size(), 200u);
}

TEST_F(PreviewWindow, SplitShowsBothAndHeatMapsWhatRaysMeet) {
  ASSERT_EQ(failure("panels off\nheatmap nodes\nsplit 0.25\nwait 2\nscreenshot @split.png\n"
                    "structure b stbvh-direct-indexed\nview split\nwait 2\nscreenshot @both.png\n"
                    "heatmap triangles\nview a\nscreenshot @triangles.png\nclose\n"),
            "");
  const Image split = shot("split.png");
  EXPECT_GT(colors(split, 0, 79).size(), 5u) << "A counts its nodes";
  EXPECT_EQ(colors(split, 82, 320), (std::set<Color>{{60, 60, 60}})) << "Embree does not";
  EXPECT_GT(colors(shot("both.png"), 82, 320).size(), 5u);
  EXPECT_NE(shot("both.png").rgb, shot("triangles.png").rgb);
}

TEST_F(PreviewWindow, DrawsTheTreeAndTheTimeLine) {
  ASSERT_EQ(
      failure(
          "panels off\nview a\nwait 2\nscreenshot @without.png\ntree 2\nscreenshot @with.png\n"
          "tree 4\nscreenshot @deeper.png\ntree off\ntimeline y\nsubtree 0 3\nscreenshot @line.png\nclose\n"),
      "");
  const Image without = shot("without.png"), with = shot("with.png"), deeper = shot("deeper.png");
  const auto changed = [&](const Image& image) {
    std::size_t count = 0;
    for (std::size_t y = 0; y < image.height; ++y) {
      for (std::size_t x = 0; x < image.width; ++x) count += at(image, x, y) != at(without, x, y) ? 1u : 0u;
    }
    return count;
  };
  EXPECT_GT(changed(with), 200u);
  EXPECT_GT(changed(deeper), changed(with));
  const Image line = shot("line.png");
  EXPECT_GT(changed(line), line.width * line.height / 8);
  EXPECT_EQ(at(line, 10, 10), at(without, 10, 10)) << "the picture above it stays";
}

TEST_F(PreviewWindow, KeepsTheSceneWhereAFileCannotBeRead) {
  std::ofstream(folder_ / "broken.glb") << "no glTF";
  const Outcome outcome =
      run("panels off\nview a\nwait 2\nscreenshot @before.png\ndrop @broken.glb\nwait 2\ndrop "
          "@missing.xml\nwait 2\n"
          "screenshot @after.png\nsave @view\nwait 2\nsleep 0.2\nclose\n");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_EQ(shot("before.png").rgb, shot("after.png").rgb);
  EXPECT_EQ(shot("view.png").rgb, shot("after.png").rgb);
  EXPECT_TRUE(fs::exists(folder_ / "view.exr"));
  EXPECT_TRUE(fs::exists(folder_ / "view-b.exr"));
}

TEST_F(PreviewWindow, OpensAFileThatIsDropped) {
  ASSERT_EQ(
      failure("panels off\nview a\nwait 2\nscreenshot @before.png\n"
              "drop " STBVH_SOURCE_DIR "/data/bending_tube.glb\nwait 2\nscreenshot @after.png\nclose\n"),
      "");
  EXPECT_NE(shot("before.png").rgb, shot("after.png").rgb);
  EXPECT_GT(colors(shot("after.png")).size(), 50u);
}

TEST_F(PreviewWindow, ResizesToOddSizes) {
  constexpr std::array<std::array<std::size_t, 2>, 4> kSizes{{{333, 217}, {64, 64}, {1001, 701}, {97, 500}}};
  std::string script = "wait 1\n";
  for (const auto& [width, height] : kSizes) {
    const std::string size = std::to_string(width) + " " + std::to_string(height);
    script += "resize " + size + "\nsleep 0.3\nwait 1\nscreenshot @" + std::to_string(width) + ".png\n";
  }
  ASSERT_EQ(failure(script + "close\n"), "");
  for (const auto& [width, height] : kSizes) {
    const Image image = shot((std::to_string(width) + ".png").c_str());
    EXPECT_EQ(image.width, width);
    EXPECT_EQ(image.height, height);
    EXPECT_GT(colors(image).size(), 20u);
  }
}

TEST_F(PreviewWindow, ClosesWhileItBuilds) {
  const auto start = std::chrono::steady_clock::now();
  std::ofstream(folder_ / "script") << "sleep 0.3\nopen wheels\nsleep 0.2\nclose\n";
  const Outcome outcome = preview("wheels --scale 2 --size 320x200 --script " + path("script"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

TEST_F(PreviewWindow, ClosesWhileItMakesAScene) {
  const auto start = std::chrono::steady_clock::now();
  std::ofstream(folder_ / "script") << "sleep 0.2\nclose\n";
  const Outcome outcome = preview("crowd --scale 1 --size 320x200 --script " + path("script"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(PreviewWindow, PlaysAndSwitchesWhileItRenders) {
  EXPECT_EQ(
      failure(
          "wait 1\nplay on\nframes 12\nsleep 0.5\nstructure a lbvh\nstructure b stbvh\nview b\nsleep 0.3\n"
          "cancel\nplay off\ndolly 0.5\nfocus 0.5 0.6\npan 0.1 0.1\nlens 0.02\nfov 60\nstructure b none\n"
          "wait 1\nscreenshot @end.png\nclose\n"),
      "");
  EXPECT_GT(colors(shot("end.png")).size(), 50u);
}

TEST_F(PreviewWindow, TakesAScreenshotAndMeasures) {
  const Outcome outcome =
      preview("wheels --scale 0.01 --samples 2 --size 320x200 --frames 20 --statistics --screenshot " +
              path("a.png"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out;
  for (const char* text : {"first picture after ", "(the window was there after ", ", the scene ", ", A "})
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << ": " << outcome.out;
  EXPECT_NE(outcome.out.find("frames, "), std::string::npos) << outcome.out;
  EXPECT_GT(colors(shot("a.png")).size(), 100u);
}

TEST_F(PreviewWindow, SaysInOneSentenceWhatCannotBeDone) {
  std::ofstream(folder_ / "broken.glb") << "no glTF";
  std::ofstream(folder_ / "script") << "orbit 1 2\njump\n";
  const std::string shot = " --screenshot " + path("a.png");
  for (const std::string& arguments :
       {"weels" + shot, path("missing.glb") + shot, path("broken.glb") + shot,
        std::string("wheels --structures stbhv"), std::string("wheels --structures stbvh,lbvh,embree"),
        std::string("wheels --size 1x1"), std::string("wheels --samples 0"), std::string("wheels --frames 3"),
        "wheels --script " + path("script"), "wheels --script " + path("nothing"),
        std::string("wheels --screenshot /nowhere/a.png"), std::string("wheels --scale -1"),
        std::string("wheels --colour")}) {
    const Outcome outcome = preview(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << ": " << outcome.out;
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1)
        << arguments << ": " << outcome.out;
    EXPECT_TRUE(outcome.out.starts_with("stbvh-preview: ")) << outcome.out;
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.png"));
}

TEST_F(PreviewWindow, SaysWhereThereIsNoDisplayOrNoOpenGL) {
  for (const char* environment : {"-u DISPLAY", "DISPLAY=:987", "MESA_GL_VERSION_OVERRIDE=2.1"}) {
    const Outcome outcome = preview("wheels", environment);
    EXPECT_EQ(outcome.exit_code, 2) << environment << ": " << outcome.out;
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1) << outcome.out;
    const bool is_about_gl = std::string(environment).starts_with("MESA");
    EXPECT_NE(outcome.out.find(is_about_gl ? "OpenGL 3.3" : "display"), std::string::npos) << outcome.out;
  }
}

}  // namespace
}  // namespace stbvh::harness
