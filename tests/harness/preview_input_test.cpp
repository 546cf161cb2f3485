/// The mouse and the keys of stbvh-preview, on an X server without a screen.
#include <X11/keysym.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <future>
#include <string>

#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"
#include "tests/harness/x_client.h"
#include "tests/harness/x_server.h"

namespace stbvh::harness {
namespace {

class PreviewInput : public ::testing::Test {
 protected:
  void SetUp() override {
    if (server_.display().empty()) GTEST_SKIP() << "there is no Xvfb (Debian: xvfb): no window is tested";
  }

  /// Starts the program; what it writes comes with `outcome`.
  void start(const std::string& script, const std::string& arguments = "") {
    std::ofstream(folder_ / "script") << script;
    const std::string command =
        "cd " + folder_.string() + "; env DISPLAY=" + server_.display() + preview_environment() +
        " " STBVH_PREVIEW " wheels --scale 0.01 --samples 2 --size 800x400 --script script " + arguments +
        " 2>&1";
    outcome_ = std::async(std::launch::async, [command] { return run_command(command); });
  }
  /// Whether the program writes the file; a machine may be busy, and a sanitizer slow.
  bool is_written(const char* name) const {
    for (int i = 0; i < 600 && !fs::exists(folder_ / name); ++i) XClient::pause(100);
    return fs::exists(folder_ / name);
  }
  /// The command line that the program wrote to `name`, from "--camera" on.
  std::string camera_in(const char* name) const {
    if (!is_written(name)) return "";
    const std::string all = read_file(folder_ / name);
    return all.substr(std::min(all.find("--camera"), all.size()));
  }

  /// Waits for the program's end.
  void expect_success() {
    const Outcome outcome = outcome_.get();
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  }

  const TemporaryFolder owner_;
  const fs::path& folder_ = owner_.path();
  const XServer server_;
  std::future<Outcome> outcome_;
};

TEST_F(PreviewInput, MouseAndKeysMoveTheCameraAndTheProgramEndsWhenItsWindowIsClosed) {
  start("wait 1\ncommand before\nsleep 6\ncommand after\nwait 1\n");
  XClient user(server_.display());
  ASSERT_TRUE(user.find_window("stbvh-preview"));
  const std::string before = camera_in("before");
  ASSERT_NE(before, "");
  user.move(600, 200);
  user.press(1);
  user.move(640, 220);
  user.move(680, 220);
  user.release(1);
  user.press(4);
  user.release(4);
  const std::string after = camera_in("after");
  EXPECT_NE(after, before) << "a drag turns";
  user.key(XK_s);
  EXPECT_TRUE(is_written("preview.png")) << "the key s saves";
  EXPECT_TRUE(is_written("preview.exr"));
  user.ask_to_close();
  expect_success();
}

TEST_F(PreviewInput, DisplaysOfDoubleDensityHavePicturesOfTheirHalf) {
  XClient user(server_.display());
  user.set_dots_per_inch(192);
  start("panels off\nwait 1\ncommand command\nscreenshot window.png\nclose\n");
  EXPECT_NE(camera_in("command"), "");
  const std::string command = read_file(folder_ / "command");
  EXPECT_NE(command.find("--size 400x200"), std::string::npos) << command;
  expect_success();
}

}  // namespace
}  // namespace stbvh::harness
