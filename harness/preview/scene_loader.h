/// Scenes and structures, made on a thread of their own while the last ones are shown.
#pragma once

#include <tbb/task_group.h>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "harness/preview/growing_picture.h"
#include "harness/program/scene_source.h"

namespace stbvh::harness {

/// What is to be there: a scene, and the structures over it.
struct LoadRequest {
  std::optional<SceneSource> source;           ///< empty: the scene that is there
  std::string asked_scene;                     ///< what `source` was found by
  std::array<std::string, kSlots> structures;  ///< names; the second may be empty
};

struct LoadProgress {
  bool is_busy = false;
  std::string stage;       ///< what is being done
  double fraction = 0;     ///< of it
  std::string problem;     ///< one sentence: why the last request could not be done; empty: it was
  std::size_t ended = 0;   ///< requests that were done, or could not be
  std::size_t builds = 0;  ///< structures built so far

  using Time = std::chrono::steady_clock::time_point;
  std::optional<Time> made;                         ///< when the last scene was made
  std::array<std::optional<Time>, kSlots> built{};  ///< when the last structures were
};

class SceneLoader {
 public:
  /// Given the structures of a request, A first, B again with it when that is built; `is_last`: no other is
  /// to be built. Called from the loader's thread.
  using Deliver = std::function<void(const BuiltPair& structures, bool is_last)>;

  /// Builds with `threads` threads.
  SceneLoader(unsigned threads, Deliver deliver);
  /// Cancels what is being made or built.
  ~SceneLoader();
  SceneLoader(const SceneLoader&) = delete;
  SceneLoader& operator=(const SceneLoader&) = delete;

  /// Cancels what is under way and does this instead. Where it fails, what was delivered last stays.
  void request(LoadRequest request);
  void cancel();
  LoadProgress progress() const;

 private:
  void serve();
  void carry_out(const LoadRequest& request);
  std::shared_ptr<const Scene> load(const LoadRequest& request);
  Scene make(const SceneSource& source);
  BuiltStructurePtr build(const std::shared_ptr<const Scene>& scene, const std::string& asked_scene,
                          const std::string& name);
  void set_stage(const std::string& stage);
  void stop();
  void end(const std::string& problem);

  unsigned threads_;
  Deliver deliver_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<LoadRequest> next_;
  std::optional<LoadRequest> opening_;  ///< under way, with a scene of which nothing has been delivered yet
  LoadProgress progress_;
  bool quit_ = false;
  bool is_serving_ = false;  ///< a request that is no longer in next_
  std::atomic<bool> cancelled_{false};
  tbb::task_group* making_ = nullptr;  ///< the scene, where one is being made
  std::atomic<double> fraction_{0};
  BuiltPair present_;  ///< of the loader's thread alone
  std::thread thread_;
};

}  // namespace stbvh::harness
