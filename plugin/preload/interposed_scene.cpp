/// A scene's life, its contents and its commits.
#include <new>

#include "plugin/preload/real_embree.h"
#include "plugin/preload/tracked_scene.h"

using stbvh::preload::real;
using stbvh::preload::scenes;

extern "C" {

RTCScene rtcNewScene(RTCDevice device) {
  const RTCScene scene = real().rtcNewScene(device);
  const auto tracked_device = scene == nullptr ? nullptr : stbvh::preload::find_device(device);
  if (tracked_device == nullptr) return scene;
  try {
    scenes().add(scene, std::make_shared<stbvh::preload::TrackedScene>(scene, tracked_device));
    return scene;
  } catch (const std::bad_alloc&) {
    real().rtcReleaseScene(scene);
    tracked_device->raise_out_of_memory();
    return nullptr;
  }
}

void rtcRetainScene(RTCScene scene) {
  real().rtcRetainScene(scene);
  scenes().retain(scene);
}

void rtcReleaseScene(RTCScene scene) {
  scenes().release(scene);
  real().rtcReleaseScene(scene);
}

unsigned rtcAttachGeometry(RTCScene scene, RTCGeometry geometry) {
  const auto tracked = scenes().find(scene);
  return tracked == nullptr ? real().rtcAttachGeometry(scene, geometry) : tracked->attach(geometry);
}

void rtcAttachGeometryByID(RTCScene scene, RTCGeometry geometry, unsigned geom_id) {
  const auto tracked = scenes().find(scene);
  if (tracked == nullptr) return real().rtcAttachGeometryByID(scene, geometry, geom_id);
  tracked->attach_by_id(geometry, geom_id);
}

void rtcDetachGeometry(RTCScene scene, unsigned geom_id) {
  const auto tracked = scenes().find(scene);
  if (tracked == nullptr) return real().rtcDetachGeometry(scene, geom_id);
  tracked->detach(geom_id);
}

void rtcCommitScene(RTCScene scene) {
  const auto tracked = scenes().find(scene);
  if (tracked == nullptr) return real().rtcCommitScene(scene);
  tracked->commit(false);
}

void rtcJoinCommitScene(RTCScene scene) {
  const auto tracked = scenes().find(scene);
  if (tracked == nullptr) return real().rtcJoinCommitScene(scene);
  tracked->commit(true);
}

void rtcSetSceneProgressMonitorFunction(RTCScene scene, RTCProgressMonitorFunction function, void* user_ptr) {
  const auto tracked = scenes().find(scene);
  if (tracked == nullptr) return real().rtcSetSceneProgressMonitorFunction(scene, function, user_ptr);
  tracked->set_progress(function, user_ptr);
}

void rtcSetSceneBuildQuality(RTCScene scene, RTCBuildQuality quality) {
  real().rtcSetSceneBuildQuality(scene, quality);
  if (const auto tracked = scenes().find(scene)) tracked->modified();
}

void rtcSetSceneFlags(RTCScene scene, RTCSceneFlags flags) {
  real().rtcSetSceneFlags(scene, flags);
  if (const auto tracked = scenes().find(scene)) tracked->modified();
}

}  // extern "C"
