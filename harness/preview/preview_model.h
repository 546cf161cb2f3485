/// All of the preview but its window: what is shown, what the user can do with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "harness/preview/animation.h"
#include "harness/preview/camera_controller.h"
#include "harness/preview/preview_session.h"
#include "harness/preview/tree_view.h"
#include "harness/preview/view_composer.h"
#include "harness/program/scene_options.h"

namespace stbvh::harness {

struct ModelOptions : MakingOptions {
  std::vector<std::string> structures;  ///< A and B, which may be missing
  unsigned threads = 1;
};

struct TreeOptions {
  bool shows_boxes = false;
  std::size_t level = 3;
  bool shows_time_line = false;
  std::size_t subtree_level = 0;  ///< of the path that was picked
  std::size_t depth = 3;          ///< of the time line below it
  std::size_t axis = 0;
};

/// The picture as it is shown, without the user interface.
struct ViewImage {
  Image image;
  std::uint64_t number = 0;  ///< grows with each change
};

class PreviewModel {
 public:
  /// `options`: how scenes are made, threads, seed; `most_samples`: where pictures end; `on_news`: called
  /// from other threads when update() would find structures, or a new picture.
  PreviewModel(const ModelOptions& options, std::size_t most_samples, PreviewSession::OnNews on_news = {});

  /// A built-in scene or a file, through the structures that are chosen. Where it is neither, problem() says
  /// so and the last scene stays.
  void open(const std::string& name);
  /// Name of structure, or empty for B. Throws UsageError for an unknown one.
  void choose_structure(std::size_t slot, const std::string& name);
  const std::array<std::string, kSlots>& chosen_structures() const { return structures_; }

  /// To be called before each frame, `elapsed` seconds behind the last: takes over what is new. `width` and
  /// `height`: of the picture, in pixels.
  void update(double elapsed, std::size_t width, std::size_t height);
  /// What is to be shown; as it was where nothing has changed. Without pixels: nothing yet.
  const ViewImage& view();

  /// The triangle that the middle of a pixel shows at the time that is scrubbed to, and the subtree that
  /// holds it: what is looked at from now on. Shares of the picture's width and height. False: there is
  /// nothing.
  bool focus(double x, double y);
  bool pick_subtree(double x, double y);

  /// Writes PATH.png as it is shown, PATH.exr with all layers through A, and PATH-b.exr through B; any
  /// extension is replaced. The latter ones as soon as each pixel has a sample; message() says when.
  void save(const std::filesystem::path& path);
  bool is_saving() const;
  /// The command that makes the picture of A and B again, with as many samples as there are.
  std::string command_line() const;

  /// The tree that is looked at: A's, or B's where A has none; null: neither has.
  const Structure* tree() const;
  TimeLine time_line() const;
  /// Boxes that are drawn, and whether these are all of the level.
  const TreeLevel& boxes() const { return boxes_; }

  const SessionState& state() const { return state_; }
  /// The structure of `slot` is chosen, and still being built.
  bool is_building(std::size_t slot) const;
  LoadProgress load_progress() const { return session_.load_progress(); }
  void cancel() { session_.loader().cancel(); }
  /// One sentence about what could not be done, or was; empty: nothing to say.
  std::string message() const;
  /// Every pixel has as many samples, of the settings as they are now, and nothing is being built.
  bool has_samples(std::size_t samples) const;
  std::uint64_t frames_played() const { return frames_played_; }
  std::size_t most_samples() const { return most_samples_; }

  CameraController camera;
  ViewOptions view_options;
  TreeOptions tree_options;
  Animation animation;
  double lens_radius = 0;

 private:
  struct Pick {
    Hit hit;
    Vec3 point;
  };
  std::optional<Pick> pick(double x, double y) const;
  RenderSettings settings() const;
  float tree_time() const;
  void say(const std::string& sentence);
  void write_layers(const std::filesystem::path& path, const GrowingPicture& picture,
                    const BuiltPair& structures, const RenderSettings& settings);

  ModelOptions options_;
  std::size_t most_samples_;
  std::array<std::string, kSlots> structures_;
  std::size_t width_ = 0, height_ = 0;
  SessionState state_;
  ViewComposer composer_;
  ViewImage view_;
  /// What view_ was made of.
  struct ComposeKey {
    std::uint64_t picture = 0, version = 0;
    ViewOptions options;
    const Structure* tree = nullptr;  ///< null: no boxes
    std::size_t level = 0;
    float time = 0;
    bool operator==(const ComposeKey&) const = default;
  };
  ComposeKey composed_;
  TreeLevel boxes_;  ///< of composed_
  TreePath picked_path_;
  std::uint64_t frames_played_ = 0;
  mutable std::mutex message_mutex_;
  std::string message_;
  std::size_t saving_ = 0;  ///< files that are still to be written
  std::size_t requests_ended_ = 0;
  bool is_loaded_ = false;  ///< all that was asked for is in state_
  PreviewSession session_;  ///< the last: its threads call back
};

}  // namespace stbvh::harness
