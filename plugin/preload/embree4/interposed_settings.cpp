/// What Embree 4 lets an application set and ask besides.
#include <span>
#include <utility>

#include "plugin/preload/native_twin.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/recording.h"
#include "plugin/preload/tracked_scene.h"

using stbvh::preload::real;
using stbvh::preload::record_buffer;
using stbvh::preload::scene_to_ask;
using stbvh::preload::scenes;
using stbvh::preload::set_and_record;
using stbvh::preload::TrackedGeometry;
using stbvh::preload::TrackedScene;

namespace {

RTCTraversable traversable_to_ask(RTCTraversable traversable) {
  return reinterpret_cast<RTCTraversable>(scene_to_ask(reinterpret_cast<RTCScene>(traversable)));
}

}  // namespace

extern "C" {

const char* rtcGetDeviceLastErrorMessage(RTCDevice device) {
  const char* const own = stbvh::preload::own_error_message(device);
  if (own != nullptr) return own;
  return real().rtcGetDeviceLastErrorMessage == nullptr ? "" : real().rtcGetDeviceLastErrorMessage(device);
}

void rtcSetGeometryEnableFilterFunctionFromArguments(RTCGeometry geometry, bool enable) {
  set_and_record<&TrackedGeometry::touched>(
      geometry, [&] { real().rtcSetGeometryEnableFilterFunctionFromArguments(geometry, enable); },
      [&](TrackedGeometry& g) { g.takes_query_filters = enable; });
}

void rtcSetGeometryInstancedScenes(RTCGeometry geometry, RTCScene* shown, size_t count) {
  std::vector<std::shared_ptr<TrackedScene>> before;  // let go of after Embree has
  set_and_record(
      geometry, [&] { real().rtcSetGeometryInstancedScenes(geometry, shown, count); },
      [&](TrackedGeometry& g) {
        std::vector<std::shared_ptr<TrackedScene>> now;
        for (const RTCScene scene : std::span(shown, count)) now.push_back(scenes().find(scene));
        before = std::exchange(g.instanced, std::move(now));
      });
}

void rtcSetSharedGeometryBufferHostDevice(RTCGeometry geometry, RTCBufferType type, unsigned slot,
                                          RTCFormat format, const void* data, const void* device_data,
                                          size_t offset, size_t stride, size_t count) {
  set_and_record(
      geometry,
      [&] {
        real().rtcSetSharedGeometryBufferHostDevice(geometry, type, slot, format, data, device_data, offset,
                                                    stride, count);
      },
      [&](TrackedGeometry& g) {
        record_buffer(g, type, slot, {format, static_cast<const char*>(data) + offset, stride, count});
      });
}

void rtcSetNewGeometryBufferHostDevice(RTCGeometry geometry, RTCBufferType type, unsigned slot,
                                       RTCFormat format, size_t stride, size_t count, void** data,
                                       void** device_data) {
  set_and_record(
      geometry,
      [&] {
        real().rtcSetNewGeometryBufferHostDevice(geometry, type, slot, format, stride, count, data,
                                                 device_data);
      },
      [&](TrackedGeometry& g) {
        record_buffer(g, type, slot,
                      {format, real().rtcGetGeometryBufferData(geometry, type, slot), stride, count});
      });
}

bool rtcTraversablePointQuery(RTCTraversable traversable, RTCPointQuery* query, RTCPointQueryContext* context,
                              RTCPointQueryFunction function, void* user_ptr) {
  return real().rtcTraversablePointQuery(traversable_to_ask(traversable), query, context, function, user_ptr);
}

#define STBVH_PACKETS(N)                                                                                  \
  bool rtcTraversablePointQuery##N(const int* valid, RTCTraversable traversable, RTCPointQuery##N* query, \
                                   RTCPointQueryContext* context, RTCPointQueryFunction function,         \
                                   void** user_ptr) {                                                     \
    return real().rtcTraversablePointQuery##N(valid, traversable_to_ask(traversable), query, context,     \
                                              function, user_ptr);                                        \
  }
STBVH_PACKETS(4)
STBVH_PACKETS(8)
STBVH_PACKETS(16)
#undef STBVH_PACKETS

}  // extern "C"
