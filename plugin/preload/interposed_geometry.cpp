/// A geometry's life and plain properties.
#include <new>

#include "plugin/preload/real_embree.h"
#include "plugin/preload/recording.h"

using stbvh::preload::geometries;
using stbvh::preload::real;
using stbvh::preload::set_and_note;
using stbvh::preload::set_and_record;
using stbvh::preload::TrackedGeometry;

extern "C" {

RTCGeometry rtcNewGeometry(RTCDevice device, RTCGeometryType type) {
  const RTCGeometry geometry = real().rtcNewGeometry(device, type);
  const auto tracked_device = geometry == nullptr ? nullptr : stbvh::preload::find_device(device);
  if (tracked_device == nullptr) return geometry;
  try {
    geometries().add(geometry, std::make_shared<TrackedGeometry>(geometry, type, device));
    return geometry;
  } catch (const std::bad_alloc&) {
    real().rtcReleaseGeometry(geometry);
    tracked_device->raise_out_of_memory();
    return nullptr;
  }
}

void rtcRetainGeometry(RTCGeometry geometry) {
  real().rtcRetainGeometry(geometry);
  geometries().retain(geometry);
}

void rtcReleaseGeometry(RTCGeometry geometry) {
  geometries().release(geometry);
  real().rtcReleaseGeometry(geometry);
}

void rtcCommitGeometry(RTCGeometry geometry) {
  const stbvh::preload::ErrorWatch watch;
  real().rtcCommitGeometry(geometry);
  if (watch.failed()) return;
  if (const auto tracked = geometries().find(geometry)) tracked->was_committed();
}

void rtcEnableGeometry(RTCGeometry geometry) {
  const auto tracked = geometries().find(geometry);
  if (tracked == nullptr) return real().rtcEnableGeometry(geometry);
  tracked->set_enabled(true);
}

void rtcDisableGeometry(RTCGeometry geometry) {
  const auto tracked = geometries().find(geometry);
  if (tracked == nullptr) return real().rtcDisableGeometry(geometry);
  tracked->set_enabled(false);
}

void rtcSetGeometryTimeStepCount(RTCGeometry geometry, unsigned count) {
  set_and_record(
      geometry, [&] { real().rtcSetGeometryTimeStepCount(geometry, count); },
      [&](TrackedGeometry& g) {
        g.step_count = count;
        g.steps.resize(count);
      });
}

void rtcSetGeometryTimeRange(RTCGeometry geometry, float start_time, float end_time) {
  set_and_record(
      geometry, [&] { real().rtcSetGeometryTimeRange(geometry, start_time, end_time); },
      [&](TrackedGeometry& g) {
        g.time_range = {start_time, end_time};
      });
}

void rtcSetGeometryMask(RTCGeometry geometry, unsigned mask) {
  set_and_record(
      geometry, [&] { real().rtcSetGeometryMask(geometry, mask); },
      [&](TrackedGeometry& g) { g.mask = mask; });
}

void rtcSetGeometryIntersectFilterFunction(RTCGeometry geometry, RTCFilterFunctionN filter) {
  set_and_record<&TrackedGeometry::touched>(
      geometry, [&] { real().rtcSetGeometryIntersectFilterFunction(geometry, filter); },
      [&](TrackedGeometry& g) { g.intersect_filter = filter; });
}

void rtcSetGeometryOccludedFilterFunction(RTCGeometry geometry, RTCFilterFunctionN filter) {
  set_and_record<&TrackedGeometry::touched>(
      geometry, [&] { real().rtcSetGeometryOccludedFilterFunction(geometry, filter); },
      [&](TrackedGeometry& g) { g.occluded_filter = filter; });
}

void rtcSetGeometryPointQueryFunction(RTCGeometry geometry, RTCPointQueryFunction function) {
  set_and_record(
      geometry, [&] { real().rtcSetGeometryPointQueryFunction(geometry, function); },
      [&](TrackedGeometry& g) { g.point_query = function; });
}

void rtcSetGeometryVertexAttributeCount(RTCGeometry geometry, unsigned count) {
  set_and_note(geometry, [&] { real().rtcSetGeometryVertexAttributeCount(geometry, count); });
}

void rtcSetGeometryBuildQuality(RTCGeometry geometry, RTCBuildQuality quality) {
  set_and_note(geometry, [&] { real().rtcSetGeometryBuildQuality(geometry, quality); });
}

void rtcSetGeometryMaxRadiusScale(RTCGeometry geometry, float scale) {
  set_and_note(geometry, [&] { real().rtcSetGeometryMaxRadiusScale(geometry, scale); });
}

}  // extern "C"
