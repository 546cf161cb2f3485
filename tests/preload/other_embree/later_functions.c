/* Preloaded, it adds to an Embree 4 what came with 4.4: on CPUs other names of what was there. As there, some
 * go through the plain functions, and so meet the preload library twice. */
#include "stbvh/stbvh_embree.h"

#if RTC_VERSION < 40400

#include "plugin/preload/embree4/later_functions.h"

#define SCENE(traversable) ((RTCScene)(void*)(traversable))

void rtcSetSharedGeometryBufferHostDevice(RTCGeometry geometry, enum RTCBufferType type, unsigned slot,
                                          enum RTCFormat format, const void* data, const void* device_data,
                                          size_t offset, size_t stride, size_t count) {
  (void)device_data;
  rtcSetSharedGeometryBuffer(geometry, type, slot, format, data, offset, stride, count);
}

void rtcSetNewGeometryBufferHostDevice(RTCGeometry geometry, enum RTCBufferType type, unsigned slot,
                                       enum RTCFormat format, size_t stride, size_t count, void** data,
                                       void** device_data) {
  void* const made = rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count);
  if (data != NULL) *data = made;
  if (device_data != NULL) *device_data = made;
}

bool rtcTraversablePointQuery(RTCTraversable traversable, struct RTCPointQuery* query,
                              struct RTCPointQueryContext* context, RTCPointQueryFunction function,
                              void* user_ptr) {
  return rtcPointQuery(SCENE(traversable), query, context, function, user_ptr);
}

void rtcTraversableIntersect1(RTCTraversable traversable, struct RTCRayHit* rayhit,
                              struct RTCIntersectArguments* options) {
  rtcIntersect1(SCENE(traversable), rayhit, options);
}

void rtcTraversableOccluded1(RTCTraversable traversable, struct RTCRay* ray,
                             struct RTCOccludedArguments* options) {
  rtcOccluded1(SCENE(traversable), ray, options);
}

#define STBVH_PACKETS(N)                                                                                     \
  bool rtcTraversablePointQuery##N(const int* valid, RTCTraversable traversable,                             \
                                   struct RTCPointQuery##N* query, struct RTCPointQueryContext* context,     \
                                   RTCPointQueryFunction function, void** user_ptr) {                        \
    return rtcPointQuery##N(valid, SCENE(traversable), query, context, function, user_ptr);                  \
  }                                                                                                          \
  void rtcTraversableIntersect##N(const int* valid, RTCTraversable traversable, struct RTCRayHit##N* rayhit, \
                                  struct RTCIntersectArguments* options) {                                   \
    rtcIntersect##N(valid, SCENE(traversable), rayhit, options);                                             \
  }                                                                                                          \
  void rtcTraversableOccluded##N(const int* valid, RTCTraversable traversable, struct RTCRay##N* ray,        \
                                 struct RTCOccludedArguments* options) {                                     \
    rtcOccluded##N(valid, SCENE(traversable), ray, options);                                                 \
  }
STBVH_PACKETS(4)
STBVH_PACKETS(8)
STBVH_PACKETS(16)

#endif
