/// Where a geometry's buffers lie; what is in them is read at commit.
#include <optional>

#include "plugin/preload/real_embree.h"
#include "plugin/preload/recording.h"

namespace stbvh::preload {
namespace {

/// What holds a geometry's time steps, for those of which we need to know it.
std::optional<RTCBufferType> step_buffers_of(RTCGeometryType type) {
  if (type == RTC_GEOMETRY_TYPE_TRIANGLE) return RTC_BUFFER_TYPE_VERTEX;
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  if (type == RTC_GEOMETRY_TYPE_INSTANCE_ARRAY) return RTC_BUFFER_TYPE_TRANSFORM;
#endif
  return std::nullopt;
}

}  // namespace

void record_buffer(TrackedGeometry& geometry, RTCBufferType type, unsigned slot, const BoundBuffer& buffer) {
  const std::optional<RTCBufferType> steps = step_buffers_of(geometry.type);
  if (!steps) return;
  if (type == RTC_BUFFER_TYPE_INDEX) geometry.indices = buffer;
  if (type != *steps || slot >= RTC_MAX_TIME_STEP_COUNT) return;
  if (geometry.steps.size() <= slot) geometry.steps.resize(slot + 1);
  geometry.steps[slot] = buffer;
}

}  // namespace stbvh::preload

using stbvh::preload::real;
using stbvh::preload::record_buffer;
using stbvh::preload::set_and_note;
using stbvh::preload::set_and_record;
using stbvh::preload::TrackedGeometry;

extern "C" {

void rtcSetGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                          RTCBuffer buffer, size_t offset, size_t stride, size_t count) {
  set_and_record(
      geometry,
      [&] { real().rtcSetGeometryBuffer(geometry, type, slot, format, buffer, offset, stride, count); },
      [&](TrackedGeometry& g) {
        const char* const start = static_cast<const char*>(real().rtcGetBufferData(buffer));
        record_buffer(g, type, slot, {format, start + offset, stride, count});
      });
}

void rtcSetSharedGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                                const void* data, size_t offset, size_t stride, size_t count) {
  set_and_record(
      geometry,
      [&] { real().rtcSetSharedGeometryBuffer(geometry, type, slot, format, data, offset, stride, count); },
      [&](TrackedGeometry& g) {
        record_buffer(g, type, slot, {format, static_cast<const char*>(data) + offset, stride, count});
      });
}

void* rtcSetNewGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                              size_t stride, size_t count) {
  void* data = nullptr;
  set_and_record(
      geometry, [&] { data = real().rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count); },
      [&](TrackedGeometry& g) {
        record_buffer(g, type, slot, {format, data, stride, count});
      });
  return data;
}

void rtcUpdateGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot) {
  set_and_note(geometry, [&] { real().rtcUpdateGeometryBuffer(geometry, type, slot); });
}

}  // extern "C"
