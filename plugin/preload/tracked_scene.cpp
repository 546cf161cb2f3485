#include "plugin/preload/tracked_scene.h"

#include "plugin/preload/real_embree.h"

namespace stbvh::preload {

Registry<RTCScene, TrackedScene>& scenes() {
  static auto* const kScenes = new Registry<RTCScene, TrackedScene>;  // outlives what runs at exit
  return *kScenes;
}

TrackedScene::~TrackedScene() {
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

std::uint64_t TrackedScene::commits() const {
  const std::lock_guard lock(mutex_);
  return commits_;
}

void TrackedScene::modified() {
  const std::lock_guard lock(mutex_);
  edits_ = next_version();
}

void TrackedScene::withdraw_proxy() {
  if (!proxy_id_) return;
  real().rtcDetachGeometry(handle_, *proxy_id_);
  proxy_id_.reset();
}

void TrackedScene::attach_proxy() {
  if (proxy_id_) return;
  // So far above that what the application attaches next gets the IDs that it would get without us.
  constexpr unsigned kSpareIds = 64;
  const unsigned proxy_id = (attachments_.empty() ? 0 : attachments_.rbegin()->first + 1) + kSpareIds;
  real().rtcAttachGeometryByID(handle_, group_->proxy(), proxy_id);
  proxy_id_ = proxy_id;
}

/// Runs `change` on Embree's scene, without the proxy if its ID may be needed, so that IDs and errors are
/// those of Embree. Where `change` failed (false) all stays as it was: the application may go on tracing
/// rays.
void TrackedScene::edit(bool needs_proxys_id, const std::function<bool()>& change) {
  const std::optional<unsigned> proxy_id = proxy_id_;
  if (needs_proxys_id) withdraw_proxy();
  if (change()) {
    edits_ = next_version();
  } else if (proxy_id && !proxy_id_) {
    real().rtcAttachGeometryByID(handle_, group_->proxy(), *proxy_id);
    proxy_id_ = proxy_id;
  }
}

unsigned TrackedScene::attach(RTCGeometry geometry) {
  unsigned geom_id = RTC_INVALID_GEOMETRY_ID;
  const std::lock_guard lock(mutex_);
  // Embree gives the lowest free ID.
  edit(proxy_id_ == attachments_.size(), [&] {
    geom_id = real().rtcAttachGeometry(handle_, geometry);
    if (geom_id == RTC_INVALID_GEOMETRY_ID) return false;
    attachments_[geom_id] = {geometry, geometries().find(geometry)};
    return true;
  });
  return geom_id;
}

void TrackedScene::attach_by_id(RTCGeometry geometry, unsigned geom_id) {
  const std::lock_guard lock(mutex_);
  edit(proxy_id_ == geom_id, [&] {
    const ErrorWatch watch;
    real().rtcAttachGeometryByID(handle_, geometry, geom_id);
    if (watch.failed() || geometry == nullptr) return false;
    attachments_[geom_id] = {geometry, geometries().find(geometry)};
    return true;
  });
}

void TrackedScene::detach(unsigned geom_id) {
  const std::lock_guard lock(mutex_);
  edit(proxy_id_ == geom_id, [&] {
    const ErrorWatch watch;
    real().rtcDetachGeometry(handle_, geom_id);
    if (watch.failed()) return false;
    attachments_.erase(geom_id);
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
