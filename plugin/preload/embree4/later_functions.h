/// What came to Embree 4 after the version whose headers are here: a program may run with a later one.
#pragma once

#include "plugin/embree_api.h"

#if RTC_VERSION < 40400

extern "C" {

/// On CPUs it is the scene.
typedef struct RTCTraversableTy* RTCTraversable;

RTC_API void rtcSetSharedGeometryBufferHostDevice(RTCGeometry geometry, RTCBufferType type, unsigned slot,
                                                  RTCFormat format, const void* data, const void* device_data,
                                                  size_t offset, size_t stride, size_t count);
RTC_API void rtcSetNewGeometryBufferHostDevice(RTCGeometry geometry, RTCBufferType type, unsigned slot,
                                               RTCFormat format, size_t stride, size_t count, void** data,
                                               void** device_data);

RTC_API bool rtcTraversablePointQuery(RTCTraversable traversable, RTCPointQuery* query,
                                      RTCPointQueryContext* context, RTCPointQueryFunction function,
                                      void* user_ptr);
RTC_API void rtcTraversableIntersect1(RTCTraversable traversable, RTCRayHit* rayhit,
                                      RTCIntersectArguments* options);
RTC_API void rtcTraversableOccluded1(RTCTraversable traversable, RTCRay* ray, RTCOccludedArguments* options);

#define STBVH_PACKETS(N)                                                                               \
  RTC_API bool rtcTraversablePointQuery##N(const int* valid, RTCTraversable traversable,               \
                                           RTCPointQuery##N* query, RTCPointQueryContext* context,     \
                                           RTCPointQueryFunction function, void** user_ptr);           \
  RTC_API void rtcTraversableIntersect##N(const int* valid, RTCTraversable traversable,                \
                                          RTCRayHit##N* rayhit, RTCIntersectArguments* options);       \
  RTC_API void rtcTraversableOccluded##N(const int* valid, RTCTraversable traversable, RTCRay##N* ray, \
                                         RTCOccludedArguments* options);
STBVH_PACKETS(4)
STBVH_PACKETS(8)
STBVH_PACKETS(16)
#undef STBVH_PACKETS

}  // extern "C"

#endif
