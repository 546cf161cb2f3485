#include "plugin/preload/tracked_scene.h"

#include <new>

#include "plugin/preload/real_embree.h"
#include "plugin/preload/scene_changes.h"

namespace stbvh::preload {

Registry<RTCScene, TrackedScene>& scenes() {
  static auto* const kScenes = new Registry<RTCScene, TrackedScene>;  // outlives what runs at exit
  return *kScenes;
}

TrackedScene::~TrackedScene() {
  while (!attachments_.empty()) remove(attachments_.begin()->first);
  scenes().forget(handle_, this);
  scenes_changed();
}

Attachments TrackedScene::attachments() const {
  const std::lock_guard lock(mutex_);
  return attachments_;
}

bool TrackedScene::has_group() const {
  const std::lock_guard lock(mutex_);
  return has_group_;
}

const plugin::Published* TrackedScene::answers_alone() const {
  const std::lock_guard lock(mutex_);
  return has_group_ && is_clean_ && !has_others_ ? group_->published() : nullptr;
}

std::uint64_t TrackedScene::commits() const {
  const std::lock_guard lock(mutex_);
  return commits_;
}

void TrackedScene::modified() {
  const std::lock_guard lock(mutex_);
  edits_ = unique_number();
}

void TrackedScene::withdraw_proxy() {
  if (!proxy_id_) return;
  real().rtcDetachGeometry(handle_, *proxy_id_);
  proxy_id_.reset();
}

/// Whether Embree took it: it may have no memory.
bool TrackedScene::attach_proxy_as(unsigned geom_id) {
  const ErrorWatch watch;
  real().rtcAttachGeometryByID(handle_, group_->proxy(), geom_id);
  if (!watch.failed()) proxy_id_ = geom_id;
  return !watch.failed();
}

/// Throws std::bad_alloc.
void TrackedScene::attach_proxy() {
  if (proxy_id_) return;
  // So far above that what the application attaches next gets the IDs that it would get without us.
  constexpr unsigned kSpareIds = 64;
  const unsigned proxy_id = (attachments_.empty() ? 0 : attachments_.rbegin()->first + 1) + kSpareIds;
  if (!attach_proxy_as(proxy_id)) throw std::bad_alloc();
}

/// Runs `change` on Embree's scene, without the proxy if its ID may be needed, so that IDs and errors are
/// those of Embree. Where `change` failed (false) all stays as it was: the application may go on tracing
/// rays.
template <typename Change>
void TrackedScene::edit(bool needs_proxys_id, Change&& change) {
  const std::optional<unsigned> proxy_id = proxy_id_;
  if (needs_proxys_id) withdraw_proxy();
  if (change()) {
    edits_ = unique_number();
  } else if (proxy_id && !proxy_id_) {
    attach_proxy_as(*proxy_id);
  }
}

/// What attachments_ will hold, made before Embree is told; empty, and the error raised, without memory.
Attachments::node_type TrackedScene::new_attachment(RTCGeometry geometry) {
  try {
    Attachments one;
    one[0] = {geometry, geometries().find(geometry)};
    return one.extract(one.begin());
  } catch (const std::bad_alloc&) {
    device_->raise_out_of_memory();
    return {};
  }
}

void TrackedScene::remove(unsigned geom_id) {
  const auto attachment = attachments_.find(geom_id);
  if (attachment == attachments_.end()) return;
  if (attachment->second.geometry != nullptr) --attachment->second.geometry->attachments;
  attachments_.erase(attachment);
}

void TrackedScene::enter(Attachments::node_type attachment, unsigned geom_id) {
  remove(geom_id);
  if (attachment.mapped().geometry != nullptr) ++attachment.mapped().geometry->attachments;
  attachment.key() = geom_id;
  attachments_.insert(std::move(attachment));
}

unsigned TrackedScene::attach(RTCGeometry geometry) {
  unsigned geom_id = RTC_INVALID_GEOMETRY_ID;
  Attachments::node_type attachment = new_attachment(geometry);
  if (attachment.empty()) return geom_id;
  const std::lock_guard lock(mutex_);
  // Embree gives the lowest free ID.
  edit(proxy_id_ == attachments_.size(), [&] {
    geom_id = real().rtcAttachGeometry(handle_, geometry);
    if (geom_id == RTC_INVALID_GEOMETRY_ID) return false;
    enter(std::move(attachment), geom_id);
    return true;
  });
  return geom_id;
}

void TrackedScene::attach_by_id(RTCGeometry geometry, unsigned geom_id) {
  Attachments::node_type attachment = new_attachment(geometry);
  if (attachment.empty()) return;
  const std::lock_guard lock(mutex_);
  edit(proxy_id_ == geom_id, [&] {
    const ErrorWatch watch;
    real().rtcAttachGeometryByID(handle_, geometry, geom_id);
    if (watch.failed() || geometry == nullptr) return false;
    enter(std::move(attachment), geom_id);
    return true;
  });
}

void TrackedScene::detach(unsigned geom_id) {
  const std::lock_guard lock(mutex_);
  edit(proxy_id_ == geom_id, [&] {
    const ErrorWatch watch;
    real().rtcDetachGeometry(handle_, geom_id);
    if (watch.failed()) return false;
    remove(geom_id);
    return true;
  });
}

void TrackedScene::set_progress(RTCProgressMonitorFunction function, void* user_ptr) {
  const std::lock_guard lock(mutex_);
  progress_ = function;
  progress_user_ptr_ = user_ptr;
  real().rtcSetSceneProgressMonitorFunction(handle_, function == nullptr ? nullptr : native_progress, this);
}

bool TrackedScene::report_progress(double fraction) {
  std::unique_lock lock(mutex_);
  const RTCProgressMonitorFunction function = progress_;
  void* const user_ptr = progress_user_ptr_;
  lock.unlock();
  return function == nullptr || function(user_ptr, fraction);
}

/// The progress of Embree's part of a commit, which is the second.
bool TrackedScene::native_progress(void* scene, double fraction) {
  TrackedScene& self = *static_cast<TrackedScene*>(scene);
  std::unique_lock lock(self.mutex_);
  const double own_share = self.own_share_;
  lock.unlock();
  return self.report_progress(own_share + (1 - own_share) * fraction);
}

}  // namespace stbvh::preload
