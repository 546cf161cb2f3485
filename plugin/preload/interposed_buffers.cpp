/// Where a geometry's buffers lie; what is in them is read at commit.
#include "plugin/preload/real_embree.h"
#include "plugin/preload/recording.h"

using stbvh::preload::BoundBuffer;
using stbvh::preload::real;
using stbvh::preload::set_and_note;
using stbvh::preload::set_and_record;
using stbvh::preload::TrackedGeometry;

namespace {

void record_buffer(TrackedGeometry& geometry, RTCBufferType type, unsigned slot, const BoundBuffer& buffer) {
  if (geometry.type != RTC_GEOMETRY_TYPE_TRIANGLE) return;
  if (type == RTC_BUFFER_TYPE_INDEX) geometry.indices = buffer;
  if (type != RTC_BUFFER_TYPE_VERTEX || slot >= RTC_MAX_TIME_STEP_COUNT) return;
  if (geometry.vertices.size() <= slot) geometry.vertices.resize(slot + 1);
  geometry.vertices[slot] = buffer;
}

}  // namespace

extern "C" {

void rtcSetGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                          RTCBuffer buffer, size_t offset, size_t stride, size_t count) {
  set_and_record(
      geometry,
      [&] { real().rtcSetGeometryBuffer(geometry, type, slot, format, buffer, offset, stride, count); },
      [&](TrackedGeometry& g) {
        const char* const start = static_cast<const char*>(real().rtcGetBufferData(buffer));
        record_buffer(g, type, slot, {start + offset, stride, count});
      });
}

void rtcSetSharedGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                                const void* data, size_t offset, size_t stride, size_t count) {
  set_and_record(
      geometry,
      [&] { real().rtcSetSharedGeometryBuffer(geometry, type, slot, format, data, offset, stride, count); },
      [&](TrackedGeometry& g) {
        record_buffer(g, type, slot, {static_cast<const char*>(data) + offset, stride, count});
      });
}

void* rtcSetNewGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                              size_t stride, size_t count) {
  void* data = nullptr;
  set_and_record(
      geometry, [&] { data = real().rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count); },
      [&](TrackedGeometry& g) {
        record_buffer(g, type, slot, {data, stride, count});
      });
  return data;
}

void rtcUpdateGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot) {
  set_and_note(geometry, [&] { real().rtcUpdateGeometryBuffer(geometry, type, slot); });
}

}  // extern "C"
