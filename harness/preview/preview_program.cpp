#include "harness/preview/preview_program.h"

#include <fmt/format.h>
#include <imgui.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <optional>
#include <utility>

#include "harness/images/png_file.h"
#include "harness/preview/frame_times.h"
#include "harness/preview/panels.h"
#include "harness/preview/preview_options.h"
#include "harness/preview/preview_script.h"
#include "harness/preview/window.h"
#include "harness/program/program.h"
#include "harness/program/usage_error.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

using Clock = std::chrono::steady_clock;

/// While the user acts, and while only the picture grows: what is left is for those that render.
constexpr double kLeastFrameSeconds = 1.0 / 60, kLeastQuietFrameSeconds = 1.0 / 40;
/// Before there is a picture, which wakes the window: making the scene and building need the time.
constexpr double kLeastEmptyFrameSeconds = 1.0 / 5;
constexpr double kActiveSeconds = 0.5;  // after input
constexpr double kIdleSeconds = 0.1;    // between looks at whether there is anything new

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class Preview final : public ScriptStage {
 public:
  Preview(const PreviewOptions& options, Clock::time_point start)
      : options_(options),
        start_(start),
        model_(options, options.most_samples, [this] { wake(); }),
        script_(options.script ? read_script(*options.script) : std::vector<ScriptCommand>(), model_, *this) {
    if (options.screenshot) check_writable(*options.screenshot);
    model_.open(options.scene);
    if (!model_.load_progress().is_busy) throw UsageError(model_.message());
    // The scene is being made meanwhile.
    window_.emplace("stbvh-preview", static_cast<int>(options.width), static_cast<int>(options.height));
    is_awaiting_picture_ = true;
    window_ready_ = Clock::now();
  }

  void run() {
    while (!window_->is_closed()) {
      const bool has_input = window_->wait_for_input(pause());
      if (has_input) last_input_ = Clock::now();
      for (const std::string& file : window_->take_dropped()) model_.open(file);
      const double elapsed = seconds_since(last_update_);
      last_update_ = Clock::now();
      if (!script_.is_done()) script_.step(elapsed);
      if (window_->is_closed()) break;
      draw(elapsed);
      fail_without_a_scene();
      // A frame that waited for something to show is no measure of the window.
      if (!is_idle_ && frames_ > 0) times_.add(seconds_since(last_swap_));
      last_swap_ = Clock::now();
      is_idle_ = !has_news(has_input);
      end_where_done();
    }
    window_->hide();  // threads may still take a moment to end
    if (options_.prints_statistics) print_statistics();
  }

  void resize(int width, int height) override { window_->resize(width, height); }
  void show_panels(bool shown) override { panels_.is_shown = shown; }
  void take_screenshot(const std::filesystem::path& file) override { screenshot_ = file; }
  void close() override { window_->close(); }

 private:
  void draw(double elapsed) {
    window_->begin_frame();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const WindowArea area = picture_area(panels_, size.x, size.y, window_->scale());
    const Window::PixelCount pixels = window_->pixels_of(area);
    handle_picture_input(model_, panels_, area, *window_);
    model_.update(elapsed, pixels.width, pixels.height);
    const ViewImage& view = model_.view();
    window_->show_image(view.image, view.number, area);
    draw_split_line(model_, area, window_->scale());
    draw_panels(model_, panels_, times_, area, *window_);
    window_->end_frame([this] {
      if (screenshot_) write_png(window_->read_frame(), *std::exchange(screenshot_, std::nullopt));
    });
    is_drawn_ = true;
    if (view.number == 0) return;
    if (frames_ == 0) first_picture_ = seconds_since(start_);
    is_awaiting_picture_ = false;
    ++frames_;
  }

  /// From other threads. Later the window is drawn often enough without.
  void wake() {
    if (is_awaiting_picture_) Window::wake();
  }

  /// The first scene that cannot be read ends the program: there is nothing to stay.
  void fail_without_a_scene() {
    const LoadProgress loading = model_.load_progress();
    if (!loading.is_busy && !loading.problem.empty() && model_.state().scene_number == 0 && is_batch())
      throw UsageError(loading.problem);
  }
  bool is_batch() const { return options_.screenshot || options_.script; }

  /// Whether the next frame will differ from this one.
  bool has_news(bool has_input) const {
    const SessionState& state = model_.state();
    const bool is_growing =
        state.picture && (!state.is_up_to_date || state.figures.samples < model_.most_samples());
    return has_input || seconds_since(last_input_) < kActiveSeconds || is_growing ||
           model_.animation.is_playing || model_.load_progress().is_busy || !script_.is_done() ||
           options_.screenshot || model_.is_saving();
  }

  double pause() const {
    if (!is_drawn_) return 0;
    if (is_idle_) return kIdleSeconds;
    const double quiet = frames_ == 0 ? kLeastEmptyFrameSeconds : kLeastQuietFrameSeconds;
    const double least = seconds_since(last_input_) < kActiveSeconds ? kLeastFrameSeconds : quiet;
    return std::max(0.0, least - seconds_since(last_update_));
  }

  void end_where_done() {
    if (!options_.screenshot || !script_.is_done()) return;
    if (frames_ == options_.frames) {
      screenshot_ = options_.screenshot;
    } else if (frames_ > options_.frames) {
      window_->close();
    }
  }

  void print_statistics() const {
    fmt::print("first picture after {:.3f} s (the window was there after {}, the scene {}, A {}, B {})\n",
               first_picture_, after(window_ready_), after(model_.load_progress().made),
               after(model_.load_progress().built[0]), after(model_.load_progress().built[1]));
    fmt::print("the last picture was there, coarse, after {:.1f} ms\n",
               1e3 * model_.state().figures.first_pass_seconds);
    fmt::print("{} frames, {:.1f} a second; 95 % within {:.1f} ms, slowest {:.1f} ms\n", times_.count(),
               times_.mean() > 0 ? 1 / times_.mean() : 0, 1e3 * times_.quantile(0.95),
               1e3 * times_.quantile(1));
    std::fflush(stdout);
  }

  /// From the start of the program.
  std::string after(std::optional<Clock::time_point> time) const {
    return time ? fmt::format("{:.3f} s", std::chrono::duration<double>(*time - start_).count()) : "-";
  }

  PreviewOptions options_;
  Clock::time_point start_, window_ready_, last_swap_ = Clock::now(), last_update_ = Clock::now();
  Clock::time_point last_input_{};  // long ago
  std::optional<Window> window_;    ///< the last to go: threads of the model wake it
  std::atomic<bool> is_awaiting_picture_{false};
  PreviewModel model_;
  PanelState panels_;
  FrameTimes times_;
  ScriptRunner script_;
  std::optional<std::filesystem::path> screenshot_;
  std::size_t frames_ = 0;  ///< with a picture in them
  double first_picture_ = 0;
  bool is_drawn_ = false;  ///< for the first time
  bool is_idle_ = false;
};

}  // namespace

int run_preview(int argc, const char* const* argv) {
  const Clock::time_point start = Clock::now();
  return run_as_program([&] {
    const std::optional<PreviewOptions> options = parse_preview_options(argc, argv);
    if (options) Preview(*options, start).run();
  });
}

}  // namespace stbvh::harness
