#include "plugin/preload/native_twin.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <new>
#include <utility>

#include "plugin/preload/real_embree.h"
#include "plugin/preload/scene_changes.h"
#include "plugin/preload/statistics.h"
#include "plugin/preload/tracked_scene.h"

namespace stbvh::preload {
namespace {

bool shows_groups(const TrackedGeometry& instance);

bool contains_groups(const TrackedScene& scene) {
  if (scene.has_group()) return true;
  for (const auto& [geom_id, attachment] : scene.attachments()) {
    if (attachment.geometry != nullptr && shows_groups(*attachment.geometry)) return true;
  }
  return false;
}

bool shows_groups(const TrackedGeometry& instance) {
  return std::any_of(instance.instanced.begin(), instance.instanced.end(),
                     [](const auto& scene) { return scene != nullptr && contains_groups(*scene); });
}

void share_buffer(RTCGeometry copy, RTCBufferType type, unsigned slot, const BoundBuffer& buffer) {
  real().rtcSetSharedGeometryBuffer(copy, type, slot, buffer.format, buffer.data, 0, buffer.stride,
                                    buffer.count);
}

void share_steps(RTCGeometry copy, RTCBufferType type, const TrackedGeometry& geometry) {
  for (unsigned step = 0; step < geometry.steps.size(); ++step) {
    if (geometry.steps[step].data != nullptr) share_buffer(copy, type, step, geometry.steps[step]);
  }
}

void set_times(RTCGeometry copy, const TrackedGeometry& geometry) {
  real().rtcSetGeometryTimeStepCount(copy, geometry.step_count);
  if (geometry.step_count > 1) {
    real().rtcSetGeometryTimeRange(copy, geometry.time_range.begin, geometry.time_range.end);
  }
}

RTCGeometry copy_of_mesh(const TrackedGeometry& mesh) {
  const RTCGeometry copy = real().rtcNewGeometry(mesh.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  set_times(copy, mesh);
  share_buffer(copy, RTC_BUFFER_TYPE_INDEX, 0, mesh.indices);
  share_steps(copy, RTC_BUFFER_TYPE_VERTEX, mesh);
  real().rtcSetGeometryMask(copy, mesh.mask);
  return copy;
}

RTCScene twin_of(const std::shared_ptr<TrackedScene>& scene) {
  return scene == nullptr ? nullptr : scene->twin().scene_to_ask(*scene);
}

#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)

RTCGeometry copy_of_instance_array(const TrackedGeometry& instances) {
  const RTCGeometry copy = real().rtcNewGeometry(instances.device, instances.type);
  set_times(copy, instances);
  if (instances.indices.data != nullptr) {
    std::vector<RTCScene> scenes;
    for (const auto& scene : instances.instanced) scenes.push_back(twin_of(scene));
    real().rtcSetGeometryInstancedScenes(copy, scenes.data(), scenes.size());
    share_buffer(copy, RTC_BUFFER_TYPE_INDEX, 0, instances.indices);
  } else {  // of many scenes Embree would look for indices
    real().rtcSetGeometryInstancedScene(copy, twin_of(instances.instanced.front()));
  }
  share_steps(copy, RTC_BUFFER_TYPE_TRANSFORM, instances);
  real().rtcSetGeometryMask(copy, instances.mask);
  return copy;
}

#endif

RTCGeometry copy_of_instance(const TrackedGeometry& instance) {
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  if (instance.type == RTC_GEOMETRY_TYPE_INSTANCE_ARRAY) return copy_of_instance_array(instance);
#endif
  const RTCGeometry copy = real().rtcNewGeometry(instance.device, RTC_GEOMETRY_TYPE_INSTANCE);
  real().rtcSetGeometryInstancedScene(copy, twin_of(instance.instanced.front()));
  set_times(copy, instance);
  for (unsigned step = 0; step < instance.transforms.size() && step < instance.step_count; ++step) {
    const InstanceTransform& transform = instance.transforms[step];
    switch (transform.kind) {
      case InstanceTransform::Kind::kNone:
        break;
      case InstanceTransform::Kind::kMatrix:
        real().rtcSetGeometryTransform(copy, step, transform.format, transform.matrix.data());
        break;
      case InstanceTransform::Kind::kQuaternion:
        real().rtcSetGeometryTransformQuaternion(copy, step, &transform.quaternion);
        break;
    }
  }
  real().rtcSetGeometryMask(copy, instance.mask);
  return copy;
}

/// A new reference to what stands for the attachment in the twin.
RTCGeometry stand_in(const Attachment& attachment) {
  TrackedGeometry* const geometry = attachment.geometry.get();
  RTCGeometry copy = nullptr;
  if (geometry != nullptr && geometry->is_taken_over()) {
    copy = copy_of_mesh(*geometry);
  } else if (geometry != nullptr && geometry->enabled && shows_groups(*geometry)) {
    copy = copy_of_instance(*geometry);
  } else {
    real().rtcRetainGeometry(attachment.handle);
    return attachment.handle;
  }
  real().rtcSetGeometryUserData(copy, real().rtcGetGeometryUserData(attachment.handle));
  real().rtcSetGeometryPointQueryFunction(copy, geometry->point_query);
  real().rtcCommitGeometry(copy);
  return copy;
}

}  // namespace

NativeTwin::~NativeTwin() {
  if (twin_ != nullptr) real().rtcReleaseScene(twin_);
}

void NativeTwin::collect_origin(const TrackedScene& scene, Origin& origin) {
  origin.emplace_back(&scene, scene.commits());
  for (const auto& [geom_id, attachment] : scene.attachments()) {
    if (attachment.geometry == nullptr) continue;
    for (const auto& instanced : attachment.geometry->instanced) {
      if (instanced != nullptr) collect_origin(*instanced, origin);
    }
  }
}

RTCScene NativeTwin::make(TrackedScene& scene) {
  const RTCScene twin = real().rtcNewScene(scene.device()->handle());
  real().rtcSetSceneFlags(twin, real().rtcGetSceneFlags(scene.handle()));
  for (const auto& [geom_id, attachment] : scene.attachments()) {
    const RTCGeometry geometry = stand_in(attachment);
    real().rtcAttachGeometryByID(twin, geometry, geom_id);
    real().rtcReleaseGeometry(geometry);
  }
  real().rtcCommitScene(twin);
  count_native_twin();
  return twin;
}

RTCScene NativeTwin::scene_to_ask(TrackedScene& scene) {
  if (!contains_groups(scene)) return scene.handle();
  const std::lock_guard lock(mutex_);
  Origin origin;
  collect_origin(scene, origin);
  if (twin_ != nullptr && origin == origin_) return twin_;
  if (twin_ != nullptr) real().rtcReleaseScene(std::exchange(twin_, nullptr));
  // Isolated: a thread that waits for its build must not pick up a query that waits for this lock.
  twin_ = tbb::this_task_arena::isolate([&] { return make(scene); });
  origin_ = std::move(origin);
  return twin_;
}

RTCScene scene_to_ask(RTCScene scene) {
  thread_local SceneAnswers<RTCScene> answers;
  std::shared_ptr<TrackedScene> tracked;
  try {
    return answers.of(scene, [&] {
      tracked = scenes().find(scene);
      return tracked == nullptr ? scene : tracked->twin().scene_to_ask(*tracked);
    });
  } catch (const std::bad_alloc&) {
    tracked->device()->raise_out_of_memory();
    return scene;
  }
}

}  // namespace stbvh::preload
