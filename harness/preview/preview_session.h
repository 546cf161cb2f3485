/// A scene, its structures and a picture of it that grows, on threads of their own: what a window shows, and
/// a test without a window asks.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "harness/preview/growing_picture.h"
#include "harness/preview/scene_loader.h"

namespace stbvh::harness {

/// What is there now.
struct SessionState {
  BuiltPair structures;
  std::uint64_t scene_number = 0;         ///< grows with each scene
  std::shared_ptr<ShownPicture> picture;  ///< the newest with something in every place; null: none yet
  std::uint64_t picture_number = 0;       ///< grows with each picture
  PictureFigures figures;                 ///< of it
  std::string problem;                    ///< why the scene cannot be shown so; empty: it can
  bool is_up_to_date = false;             ///< the picture is of the last settings, on all structures
};

class PreviewSession {
 public:
  /// Called from the threads when structures or a new picture are there.
  using OnNews = std::function<void()>;

  /// Builds and renders with `threads` threads; pictures end at `most_samples` samples. Throws
  /// std::system_error where the system gives no more threads.
  PreviewSession(unsigned threads, std::size_t most_samples, OnNews on_news = {});
  ~PreviewSession();
  PreviewSession(const PreviewSession&) = delete;
  PreviewSession& operator=(const PreviewSession&) = delete;

  SceneLoader& loader() { return *loader_; }
  LoadProgress load_progress() const { return loader_->progress(); }

  /// Begins a new picture of scene `scene_number`; it takes the place of the last one as soon as its coarsest
  /// pass is there. Does nothing where the settings are the same, or the scene is there no longer. A new
  /// scene is not shown before it has settings.
  void set_settings(const RenderSettings& settings, std::uint64_t scene_number);

  SessionState state() const;

  /// Calls `work` with the picture, when each of its pixels has the same number of samples, on the thread
  /// that renders.
  using PictureWork = std::function<void(const GrowingPicture& picture, const BuiltPair& structures,
                                         const RenderSettings& settings)>;
  void with_picture(PictureWork work);

 private:
  struct NotStarted {};
  PreviewSession(unsigned threads, std::size_t most_samples, OnNews on_news, NotStarted);

  void deliver(const BuiltPair& structures, bool is_last);
  void wait_for_first_picture(std::unique_lock<std::mutex>& lock);
  void tell() const;
  void render();
  void change();
  void begin_picture(std::unique_lock<std::mutex>& lock);
  void do_work(std::unique_lock<std::mutex>& lock);
  void grow_picture(std::unique_lock<std::mutex>& lock);
  bool is_growing() const;
  bool can_work() const;

  const std::size_t most_samples_;
  const OnNews on_news_;
  mutable std::mutex mutex_;
  std::condition_variable wake_, first_shown_;
  RenderSettings settings_;
  bool has_settings_ = false;
  bool is_changed_ = false;  ///< settings or structures, since the picture was begun
  bool quit_ = false;
  std::atomic<bool> stop_pass_{false};
  bool is_begun_ = false;         ///< there is a picture to add passes to
  bool has_shown_scene_ = false;  ///< something in every place, since the scene came
  std::vector<PictureWork> work_;
  SessionState state_;
  WorkCrew crew_;
  GrowingPicture picture_;  ///< of the rendering thread
  BuiltPair rendered_;      ///< what it is of; of the rendering thread
  RenderSettings rendered_settings_;
  std::thread renderer_;
  std::optional<SceneLoader> loader_;  ///< the last: it delivers to all of the above
};

}  // namespace stbvh::harness
