#include "plugin/preload/tracked_geometry.h"

#include <span>

#include "plugin/preload/environment.h"
#include "plugin/preload/real_embree.h"
#include "stbvh/mesh_view.h"

namespace stbvh::preload {
namespace {

/// Whether what was recorded is what Embree has.
bool is_bound(RTCGeometry geometry, RTCBufferType type, unsigned slot, const BoundBuffer& buffer) {
  return buffer.data != nullptr && real().rtcGetGeometryBufferData(geometry, type, slot) == buffer.data;
}

}  // namespace

Registry<RTCGeometry, TrackedGeometry>& geometries() {
  static auto* const kGeometries = new Registry<RTCGeometry, TrackedGeometry>;  // outlives what runs at exit
  return *kGeometries;
}

TrackedGeometry::~TrackedGeometry() {
  geometries().forget(handle, this);
}

void TrackedGeometry::modified() {
  committed = false;
  version = unique_number();
}

void TrackedGeometry::touched() {
  version = unique_number();
}

void TrackedGeometry::was_committed() {
  committed = true;
  version = unique_number();
}

void TrackedGeometry::set_enabled(bool value) {
  const std::lock_guard lock(mutex_);
  enabled = value;
  version = unique_number();
  if (!given_to_embree_ || natively_enabled_ == value) return;
  natively_enabled_ = value;
  value ? real().rtcEnableGeometry(handle) : real().rtcDisableGeometry(handle);
}

void TrackedGeometry::give_to_embree(bool value) {
  const std::lock_guard lock(mutex_);
  given_to_embree_ = value;
  const bool wanted = value && enabled;
  if (natively_enabled_ == wanted) return;
  natively_enabled_ = wanted;
  wanted ? real().rtcEnableGeometry(handle) : real().rtcDisableGeometry(handle);
}

bool TrackedGeometry::is_taken_over() {
  const std::lock_guard lock(mutex_);
  return enabled && !given_to_embree_;
}

StaysNative TrackedGeometry::why_native() const {
  if (step_count < 2 && !environment().all_triangles) return StaysNative::kOneStep;
  return why_native_but_for_rest();
}

StaysNative TrackedGeometry::why_native_but_for_rest() const {
  if (!committed) return StaysNative::kUncommitted;
  if (!is_known) return StaysNative::kNoMemory;
  if (too_large) return StaysNative::kTooLarge;
  if (step_count > 1 && !is_usable(time_range)) return StaysNative::kTimeRange;
  return has_buffers() && can_be_built() ? StaysNative::kNone : StaysNative::kBuffers;
}

bool TrackedGeometry::has_buffers() const {
  if (steps.size() < step_count) return false;
  if (!is_bound(handle, RTC_BUFFER_TYPE_INDEX, 0, indices)) return false;
  for (unsigned step = 0; step < step_count; ++step) {
    if (!is_bound(handle, RTC_BUFFER_TYPE_VERTEX, step, steps[step])) return false;
    // Embree wants them alike, and says so where they are not.
    if (steps[step].count != steps[0].count || steps[step].stride != steps[0].stride) return false;
  }
  return true;
}

/// One mesh that the build refuses would take all others of the scene with it.
bool TrackedGeometry::can_be_built() const {
  std::vector<VertexBufferView> vertices;
  return problem_of(view(vertices)) == nullptr;
}

MeshView TrackedGeometry::view(std::vector<VertexBufferView>& vertices) const {
  vertices.clear();
  for (const BoundBuffer& step : std::span(steps).first(step_count)) {
    vertices.push_back({step.data, step.count, step.stride});
  }
  MeshView view;
  view.indices = indices.data;
  view.triangle_count = indices.count;
  view.index_stride = indices.stride;
  view.steps = vertices;
  view.time_range = time_range;
  view.mask = mask;
  return view;
}

}  // namespace stbvh::preload
