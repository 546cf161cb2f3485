/// What came to Embree 4 after the version whose headers are here: a program may run with a later one.
#pragma once

#include "stbvh/stbvh_embree.h"

#if RTC_VERSION < 40400

#if defined(__cplusplus)
extern "C" {
#endif

/// On CPUs it is the scene.
typedef struct RTCTraversableTy* RTCTraversable;

RTC_API void rtcSetSharedGeometryBufferHostDevice(RTCGeometry geometry, enum RTCBufferType type,
                                                  unsigned slot, enum RTCFormat format, const void* data,
                                                  const void* device_data, size_t offset, size_t stride,
                                                  size_t count);
RTC_API void rtcSetNewGeometryBufferHostDevice(RTCGeometry geometry, enum RTCBufferType type, unsigned slot,
                                               enum RTCFormat format, size_t stride, size_t count,
                                               void** data, void** device_data);

RTC_API bool rtcTraversablePointQuery(RTCTraversable traversable, struct RTCPointQuery* query,
                                      struct RTCPointQueryContext* context, RTCPointQueryFunction function,
                                      void* user_ptr);
RTC_API void rtcTraversableIntersect1(RTCTraversable traversable, struct RTCRayHit* rayhit,
                                      struct RTCIntersectArguments* options);
RTC_API void rtcTraversableOccluded1(RTCTraversable traversable, struct RTCRay* ray,
                                     struct RTCOccludedArguments* options);

#define STBVH_PACKETS(N)                                                                      \
  RTC_API bool rtcTraversablePointQuery##N(                                                   \
      const int* valid, RTCTraversable traversable, struct RTCPointQuery##N* query,           \
      struct RTCPointQueryContext* context, RTCPointQueryFunction function, void** user_ptr); \
  RTC_API void rtcTraversableIntersect##N(const int* valid, RTCTraversable traversable,       \
                                          struct RTCRayHit##N* rayhit,                        \
                                          struct RTCIntersectArguments* options);             \
  RTC_API void rtcTraversableOccluded##N(const int* valid, RTCTraversable traversable,        \
                                         struct RTCRay##N* ray, struct RTCOccludedArguments* options);
STBVH_PACKETS(4)
STBVH_PACKETS(8)
STBVH_PACKETS(16)
#undef STBVH_PACKETS

#if defined(__cplusplus)
}  // extern "C"
#endif

#endif
