#include "harness/preview/preview_session.h"

#include <chrono>
#include <exception>
#include <new>
#include <utility>

namespace stbvh::harness {
namespace {

/// Longest that the build of B waits for the first picture through A: no longer than a user would notice,
/// where the window does not ask for one.
constexpr std::chrono::milliseconds kLongestWaitForPicture{300};

bool is_same(Vec3f a, Vec3f b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

bool is_same(const Camera& a, const Camera& b) {
  return is_same(a.position, b.position) && is_same(a.target, b.target) && is_same(a.up, b.up) &&
         a.vertical_fov_degrees == b.vertical_fov_degrees;
}

/// As far as the preview changes settings.
bool is_same(const RenderSettings& a, const RenderSettings& b) {
  const Shutter &s = a.shutter, &t = b.shutter;
  return a.width == b.width && a.height == b.height && a.seed == b.seed && a.lens.radius == b.lens.radius &&
         s.open == t.open && s.close == t.close && s.opening == t.opening && s.closing == t.closing &&
         a.camera.has_value() == b.camera.has_value() && (!a.camera || is_same(*a.camera, *b.camera));
}

}  // namespace

PreviewSession::PreviewSession(unsigned threads, std::size_t most_samples, OnNews on_news, NotStarted)
    : most_samples_(most_samples), on_news_(std::move(on_news)), crew_(threads), picture_(crew_) {}

// Where a thread cannot be started the destructor ends those before it: the constructor that it stands for is
// done.
PreviewSession::PreviewSession(unsigned threads, std::size_t most_samples, OnNews on_news)
    : PreviewSession(threads, most_samples, std::move(on_news), NotStarted{}) {
  renderer_ = std::thread([this] { render(); });
  loader_.emplace(threads,
                  [this](const BuiltPair& structures, bool is_last) { deliver(structures, is_last); });
}

PreviewSession::~PreviewSession() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
    stop_pass_ = true;
  }
  wake_.notify_all();
  first_shown_.notify_all();
  if (renderer_.joinable()) renderer_.join();
}

void PreviewSession::set_settings(const RenderSettings& settings, std::uint64_t scene_number) {
  const std::lock_guard lock(mutex_);
  if (scene_number != state_.scene_number) return;
  if (has_settings_ && is_same(settings, settings_)) return;
  settings_ = settings;
  settings_.samples_per_pixel = most_samples_;
  has_settings_ = true;
  change();
}

void PreviewSession::deliver(const BuiltPair& structures, bool is_last) {
  std::unique_lock lock(mutex_);
  const bool is_new_scene = !state_.structures[0] || state_.structures[0]->scene != structures[0]->scene;
  state_.structures = structures;
  if (is_new_scene) {
    ++state_.scene_number;
    has_settings_ = has_shown_scene_ = false;
  }
  change();
  lock.unlock();
  tell();
  lock.lock();
  if (is_new_scene && !is_last) wait_for_first_picture(lock);
}

/// What comes next is the build of B, which would take the processors from the coarsest pass.
void PreviewSession::wait_for_first_picture(std::unique_lock<std::mutex>& lock) {
  first_shown_.wait_for(lock, kLongestWaitForPicture, [this] { return quit_ || has_shown_scene_; });
}

void PreviewSession::tell() const {
  if (on_news_) on_news_();
}

/// Locked. The coarsest pass of a picture is always ended: else a camera that moves fast would show nothing.
void PreviewSession::change() {
  is_changed_ = true;
  if (picture_.passes() > 0) stop_pass_ = true;
  wake_.notify_all();
}

SessionState PreviewSession::state() const {
  const std::lock_guard lock(mutex_);
  SessionState state = state_;
  state.is_up_to_date = is_begun_ && !is_changed_ && picture_.passes() > 0;
  if (state.is_up_to_date) state.figures = picture_.figures();
  return state;
}

void PreviewSession::with_picture(PictureWork work) {
  {
    const std::lock_guard lock(mutex_);
    work_.push_back(std::move(work));
  }
  wake_.notify_all();
}

bool PreviewSession::is_growing() const {
  return is_begun_ && picture_.figures().samples < most_samples_;
}

bool PreviewSession::can_work() const {
  return !work_.empty() && is_begun_ && picture_.figures().samples > 0;
}

void PreviewSession::render() {
  lower_priority(kRendererNiceness);
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] {
      const bool can_begin = is_changed_ && has_settings_ && state_.structures[0];
      return quit_ || can_begin || can_work() || (is_growing() && !is_changed_);
    });
    if (quit_) return;
    if (is_changed_) {
      begin_picture(lock);
    } else if (can_work()) {
      do_work(lock);
    } else {
      grow_picture(lock);
    }
  }
}

void PreviewSession::begin_picture(std::unique_lock<std::mutex>& lock) {
  is_changed_ = false;
  rendered_ = state_.structures;
  rendered_settings_ = settings_;
  is_begun_ = false;
  std::string problem;
  lock.unlock();
  try {
    picture_.begin(rendered_, rendered_settings_);
  } catch (const std::bad_alloc&) {
    problem = "Not enough memory for a picture of this size.";
  } catch (const std::exception& e) {
    problem = e.what();
  }
  lock.lock();
  is_begun_ = problem.empty();
  state_.problem = problem;
  if (is_begun_) {
    grow_picture(lock);
  } else {
    has_shown_scene_ = true;  // it never will be
    first_shown_.notify_all();
  }
}

void PreviewSession::do_work(std::unique_lock<std::mutex>& lock) {
  const std::vector<PictureWork> work = std::exchange(work_, {});
  lock.unlock();
  for (const PictureWork& w : work) w(picture_, rendered_, rendered_settings_);
  lock.lock();
}

void PreviewSession::grow_picture(std::unique_lock<std::mutex>& lock) {
  stop_pass_ = quit_;
  lock.unlock();
  const bool is_done = picture_.add_pass(stop_pass_);
  lock.lock();
  if (!is_done) {
    is_begun_ = false;  // spoilt; another one comes
    return;
  }
  state_.figures = picture_.figures();
  if (picture_.passes() != 1) return;
  state_.picture = picture_.shown();
  ++state_.picture_number;
  has_shown_scene_ = rendered_[0]->scene == state_.structures[0]->scene;
  lock.unlock();
  first_shown_.notify_all();
  tell();
  lock.lock();
}

}  // namespace stbvh::harness
