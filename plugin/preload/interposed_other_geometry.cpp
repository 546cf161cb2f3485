/// Setters of geometries that are no triangle meshes: what instances show, and that anything changed at all.
#include <algorithm>
#include <utility>

#include "plugin/preload/real_embree.h"
#include "plugin/preload/recording.h"
#include "plugin/preload/tracked_scene.h"

using stbvh::preload::InstanceTransform;
using stbvh::preload::real;
using stbvh::preload::scenes;
using stbvh::preload::set_and_note;
using stbvh::preload::set_and_record;
using stbvh::preload::TrackedGeometry;
using stbvh::preload::TrackedScene;

namespace {

InstanceTransform& transform_of_step(TrackedGeometry& geometry, unsigned step) {
  if (geometry.transforms.size() <= step) geometry.transforms.resize(step + 1);
  return geometry.transforms[step];
}

}  // namespace

extern "C" {

void rtcSetGeometryInstancedScene(RTCGeometry geometry, RTCScene scene) {
  std::vector<std::shared_ptr<TrackedScene>> before;  // let go of after Embree has
  set_and_record(
      geometry, [&] { real().rtcSetGeometryInstancedScene(geometry, scene); },
      [&](TrackedGeometry& g) { before = std::exchange(g.instanced, {scenes().find(scene)}); });
}

void rtcSetGeometryTransform(RTCGeometry geometry, unsigned step, RTCFormat format, const void* transform) {
  set_and_record(
      geometry, [&] { real().rtcSetGeometryTransform(geometry, step, format, transform); },
      [&](TrackedGeometry& g) {
        InstanceTransform& record = transform_of_step(g, step);
        record.kind = InstanceTransform::Kind::kMatrix;
        record.format = format;
        const std::size_t count = format == RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR ? 16 : 12;
        std::copy_n(static_cast<const float*>(transform), count, record.matrix.begin());
      });
}

void rtcSetGeometryTransformQuaternion(RTCGeometry geometry, unsigned step,
                                       const RTCQuaternionDecomposition* quaternion) {
  set_and_record(
      geometry, [&] { real().rtcSetGeometryTransformQuaternion(geometry, step, quaternion); },
      [&](TrackedGeometry& g) {
        InstanceTransform& record = transform_of_step(g, step);
        record.kind = InstanceTransform::Kind::kQuaternion;
        record.quaternion = *quaternion;
      });
}

void rtcSetGeometryUserPrimitiveCount(RTCGeometry geometry, unsigned count) {
  set_and_note(geometry, [&] { real().rtcSetGeometryUserPrimitiveCount(geometry, count); });
}

void rtcSetGeometryBoundsFunction(RTCGeometry geometry, RTCBoundsFunction function, void* user_ptr) {
  set_and_note(geometry, [&] { real().rtcSetGeometryBoundsFunction(geometry, function, user_ptr); });
}

void rtcSetGeometryIntersectFunction(RTCGeometry geometry, RTCIntersectFunctionN function) {
  set_and_note(geometry, [&] { real().rtcSetGeometryIntersectFunction(geometry, function); });
}

void rtcSetGeometryOccludedFunction(RTCGeometry geometry, RTCOccludedFunctionN function) {
  set_and_note(geometry, [&] { real().rtcSetGeometryOccludedFunction(geometry, function); });
}

void rtcSetGeometryTessellationRate(RTCGeometry geometry, float rate) {
  set_and_note(geometry, [&] { real().rtcSetGeometryTessellationRate(geometry, rate); });
}

void rtcSetGeometryTopologyCount(RTCGeometry geometry, unsigned count) {
  set_and_note(geometry, [&] { real().rtcSetGeometryTopologyCount(geometry, count); });
}

void rtcSetGeometrySubdivisionMode(RTCGeometry geometry, unsigned topology, RTCSubdivisionMode mode) {
  set_and_note(geometry, [&] { real().rtcSetGeometrySubdivisionMode(geometry, topology, mode); });
}

void rtcSetGeometryVertexAttributeTopology(RTCGeometry geometry, unsigned attribute, unsigned topology) {
  set_and_note(geometry,
               [&] { real().rtcSetGeometryVertexAttributeTopology(geometry, attribute, topology); });
}

void rtcSetGeometryDisplacementFunction(RTCGeometry geometry, RTCDisplacementFunctionN function) {
  set_and_note(geometry, [&] { real().rtcSetGeometryDisplacementFunction(geometry, function); });
}

}  // extern "C"
