#include "harness/preview/scene_loader.h"

#include <fmt/format.h>

#include <exception>
#include <new>
#include <utility>

#include "harness/report/machine.h"
#include "harness/structures/memory_estimate.h"

namespace stbvh::harness {

SceneLoader::SceneLoader(unsigned threads, Deliver deliver)
    : threads_(threads), deliver_(std::move(deliver)), thread_([this] { serve(); }) {}

SceneLoader::~SceneLoader() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
    stop();
  }
  wake_.notify_all();
  thread_.join();
}

void SceneLoader::request(LoadRequest request) {
  {
    const std::lock_guard lock(mutex_);
    // A scene that is still to be loaded is not forgotten where only structures are chosen meanwhile.
    const std::optional<LoadRequest>& unfinished = next_ ? next_ : opening_;
    if (!request.source && unfinished) {
      request.source = unfinished->source;
      request.asked_scene = unfinished->asked_scene;
    }
    next_ = std::move(request);
    if (progress_.is_busy) stop();
    progress_.is_busy = true;
    progress_.problem.clear();
  }
  wake_.notify_all();
}

void SceneLoader::cancel() {
  const std::lock_guard lock(mutex_);
  const bool is_taken = !next_ || is_serving_;
  next_.reset();
  stop();
  if (!is_taken) end("Cancelled.");  // the thread will never see it
}

/// Locked.
void SceneLoader::end(const std::string& problem) {
  progress_.is_busy = false;
  progress_.problem = problem;
  ++progress_.ended;
}

/// Locked.
void SceneLoader::stop() {
  cancelled_ = true;
  if (making_ != nullptr) making_->cancel();
}

LoadProgress SceneLoader::progress() const {
  const std::lock_guard lock(mutex_);
  LoadProgress progress = progress_;
  progress.fraction = fraction_;
  return progress;
}

void SceneLoader::set_stage(const std::string& stage) {
  const std::lock_guard lock(mutex_);
  progress_.stage = stage;
  fraction_ = 0;
}

void SceneLoader::serve() {
  lower_priority(kBuilderNiceness);
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return quit_ || next_; });
    if (quit_) return;
    const LoadRequest request = std::exchange(next_, std::nullopt).value();
    if (request.source) opening_ = request;
    cancelled_ = false;
    is_serving_ = true;
    lock.unlock();
    std::string problem;
    try {
      carry_out(request);
    } catch (const BuildCancelled&) {
      problem = "Cancelled.";
    } catch (const std::bad_alloc&) {
      problem = "Not enough memory.";
    } catch (const std::exception& e) {
      problem = e.what();
    }
    lock.lock();
    opening_.reset();
    is_serving_ = false;
    if (!next_) end(problem);  // else it is of no interest what was wrong with the older request
  }
}

void SceneLoader::carry_out(const LoadRequest& request) {
  const std::shared_ptr<const Scene> scene = load(request);
  const std::string asked = request.source ? request.asked_scene : present_[0]->asked_scene;
  BuiltPair pair = present_;
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    const std::string& name = request.structures[slot];
    const bool is_there = pair[slot] && pair[slot]->scene == scene && pair[slot]->name == name;
    if (is_there) continue;
    // A second one of the same name is a second one: what they differ in is what chance brings.
    pair[slot] = name.empty() ? nullptr : build(scene, asked, name);
    if (slot == 0 && pair[1] && pair[1]->scene != scene) pair[1] = nullptr;
    present_ = pair;
    {
      const std::lock_guard lock(mutex_);
      opening_.reset();
      if (pair[slot]) progress_.built[slot] = std::chrono::steady_clock::now();
    }
    const bool has_b = !request.structures[1].empty();
    deliver_(pair, slot + 1 == kSlots || !has_b);
  }
}

std::shared_ptr<const Scene> SceneLoader::load(const LoadRequest& request) {
  if (!request.source) {
    if (!present_[0]) throw std::runtime_error("There is no scene yet.");
    return present_[0]->scene;
  }
  set_stage(fmt::format("{}: making the scene", request.source->name));
  auto scene = std::make_shared<const Scene>(make(*request.source));
  const std::lock_guard lock(mutex_);
  progress_.made = std::chrono::steady_clock::now();
  return scene;
}

/// In a task group: what makes scenes looks at whether it is cancelled (harness/scenes/cancellation.h).
Scene SceneLoader::make(const SceneSource& source) {
  Scene scene;
  tbb::task_group group;
  const auto set_making = [this](tbb::task_group* making) {
    const std::lock_guard lock(mutex_);
    making_ = making;
  };
  set_making(&group);
  std::exception_ptr problem;
  group.run_and_wait([&] {
    try {
      if (!cancelled_) scene = source.load();
    } catch (...) {
      problem = std::current_exception();
    }
  });
  set_making(nullptr);
  if (cancelled_) throw BuildCancelled();
  if (problem) std::rethrow_exception(problem);
  return scene;
}

BuiltStructurePtr SceneLoader::build(const std::shared_ptr<const Scene>& scene,
                                     const std::string& asked_scene, const std::string& name) {
  set_stage(fmt::format("{}: building {}", scene->name, name));
  const std::size_t needed = estimate_peak_bytes(name, *scene), available = available_memory_bytes();
  if (needed > available) {
    throw std::runtime_error(fmt::format("{} would need about {:.1f} GB, and {:.1f} GB are free.", name,
                                         static_cast<double>(needed) / 1e9,
                                         static_cast<double>(available) / 1e9));
  }
  auto built = std::make_shared<BuiltStructure>(BuiltStructure{scene, asked_scene, name, nullptr});
  built->structure = build_structure(name, *scene, threads_, [this](double fraction) {
    fraction_ = fraction;
    return !cancelled_;
  });
  if (cancelled_) throw BuildCancelled();
  const std::lock_guard lock(mutex_);
  ++progress_.builds;
  return built;
}

}  // namespace stbvh::harness
