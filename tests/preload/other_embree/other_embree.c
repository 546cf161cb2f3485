/* Stands for an Embree of another version, EMBREE_MAJOR: says each call and what it was given. Versions 3 and
 * 4 have the same functions that the preload library stands in front of; of those version 2 has rtcNewDevice
 * only. */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>

#include "stbvh/stbvh_embree.h"

/* Handles are numbers: nobody may look behind them. */
static void* handle(uintptr_t number) {
  return (void*)number;
}

RTCDevice rtcNewDevice(const char* config) {
  printf("rtcNewDevice %s\n", config);
  return handle(1000 + EMBREE_MAJOR);
}

#if EMBREE_MAJOR > 2
static void say(const char* name, int count, ...) {
  va_list arguments;
  va_start(arguments, count);
  printf("%s", name);
  for (int i = 0; i < count; ++i) printf(" %lld", va_arg(arguments, long long));
  va_end(arguments);
  printf("\n");
}

#define NUMBER(x) ((long long)(x))
#define POINTER(x) ((long long)(uintptr_t)(x))
#define SAY1(a) say(__func__, 1, POINTER(a))
#define SAY2(a, b) say(__func__, 2, POINTER(a), NUMBER(b))

/* Not said: the preload library asks. */
ssize_t rtcGetDeviceProperty(RTCDevice device, enum RTCDeviceProperty property) {
  (void)device;
  return property == RTC_DEVICE_PROPERTY_VERSION_MAJOR ? EMBREE_MAJOR : 1;
}

enum RTCError rtcGetDeviceError(RTCDevice device) {
  SAY1(device);
  return RTC_ERROR_CANCELLED;
}

void rtcSetDeviceErrorFunction(RTCDevice device, RTCErrorFunction function, void* user) {
  say(__func__, 3, POINTER(device), NUMBER(function != NULL), POINTER(user));
}

void rtcSetDeviceMemoryMonitorFunction(RTCDevice device, RTCMemoryMonitorFunction function, void* user) {
  say(__func__, 3, POINTER(device), NUMBER(function != NULL), POINTER(user));
}

RTCScene rtcNewScene(RTCDevice device) {
  SAY1(device);
  return handle(2000);
}

void rtcRetainScene(RTCScene scene) {
  SAY1(scene);
}
void rtcReleaseScene(RTCScene scene) {
  SAY1(scene);
}
void rtcCommitScene(RTCScene scene) {
  SAY1(scene);
}
void rtcJoinCommitScene(RTCScene scene) {
  SAY1(scene);
}
void rtcSetSceneFlags(RTCScene scene, enum RTCSceneFlags flags) {
  SAY2(scene, flags);
}
void rtcSetSceneBuildQuality(RTCScene scene, enum RTCBuildQuality quality) {
  SAY2(scene, quality);
}

void rtcSetSceneProgressMonitorFunction(RTCScene scene, RTCProgressMonitorFunction function, void* user) {
  say(__func__, 3, POINTER(scene), NUMBER(function != NULL), POINTER(user));
}

RTCGeometry rtcNewGeometry(RTCDevice device, enum RTCGeometryType type) {
  static uintptr_t last = 3000;
  SAY2(device, type);
  return handle(++last);
}

void rtcRetainGeometry(RTCGeometry geometry) {
  SAY1(geometry);
}
void rtcReleaseGeometry(RTCGeometry geometry) {
  SAY1(geometry);
}
void rtcCommitGeometry(RTCGeometry geometry) {
  SAY1(geometry);
}
void rtcEnableGeometry(RTCGeometry geometry) {
  SAY1(geometry);
}
void rtcDisableGeometry(RTCGeometry geometry) {
  SAY1(geometry);
}
void rtcSetGeometryTimeStepCount(RTCGeometry geometry, unsigned count) {
  SAY2(geometry, count);
}
void rtcSetGeometryMask(RTCGeometry geometry, unsigned mask) {
  SAY2(geometry, mask);
}
void rtcSetGeometryBuildQuality(RTCGeometry geometry, enum RTCBuildQuality quality) {
  SAY2(geometry, quality);
}
void rtcSetGeometryUserData(RTCGeometry geometry, void* data) {
  SAY2(geometry, POINTER(data));
}

void rtcSetGeometryTimeRange(RTCGeometry geometry, float start, float end) {
  say(__func__, 3, POINTER(geometry), NUMBER(1000 * start), NUMBER(1000 * end));
}

void rtcSetGeometryIntersectFilterFunction(RTCGeometry geometry, RTCFilterFunctionN filter) {
  SAY2(geometry, filter != NULL);
}

void rtcSetGeometryOccludedFilterFunction(RTCGeometry geometry, RTCFilterFunctionN filter) {
  SAY2(geometry, filter != NULL);
}

void rtcSetSharedGeometryBuffer(RTCGeometry geometry, enum RTCBufferType type, unsigned slot,
                                enum RTCFormat format, const void* data, size_t offset, size_t stride,
                                size_t count) {
  say(__func__, 8, POINTER(geometry), NUMBER(type), NUMBER(slot), NUMBER(format), NUMBER(data != NULL),
      NUMBER(offset), NUMBER(stride), NUMBER(count));
}

void rtcUpdateGeometryBuffer(RTCGeometry geometry, enum RTCBufferType type, unsigned slot) {
  say(__func__, 3, POINTER(geometry), NUMBER(type), NUMBER(slot));
}

void rtcSetGeometryInstancedScene(RTCGeometry geometry, RTCScene scene) {
  SAY2(geometry, POINTER(scene));
}

void rtcSetGeometryTransform(RTCGeometry geometry, unsigned step, enum RTCFormat format, const void* matrix) {
  say(__func__, 4, POINTER(geometry), NUMBER(step), NUMBER(format), NUMBER(*(const float*)matrix));
}

unsigned rtcAttachGeometry(RTCScene scene, RTCGeometry geometry) {
  SAY2(scene, POINTER(geometry));
  return 77;
}

void rtcAttachGeometryByID(RTCScene scene, RTCGeometry geometry, unsigned id) {
  say(__func__, 3, POINTER(scene), POINTER(geometry), NUMBER(id));
}

void rtcDetachGeometry(RTCScene scene, unsigned id) {
  SAY2(scene, id);
}

bool rtcPointQuery(RTCScene scene, struct RTCPointQuery* query, struct RTCPointQueryContext* context,
                   RTCPointQueryFunction function, void* user) {
  say(__func__, 5, POINTER(scene), NUMBER(query->x), NUMBER(context != NULL), NUMBER(function != NULL),
      POINTER(user));
  return true;
}

#if RTC_VERSION_MAJOR >= 4
void rtcIntersect1(RTCScene scene, struct RTCRayHit* ray, struct RTCIntersectArguments* options) {
  say(__func__, 3, POINTER(scene), NUMBER(ray->ray.tfar), POINTER(options));
}

void rtcOccluded4(const int* valid, RTCScene scene, struct RTCRay4* rays,
                  struct RTCOccludedArguments* options) {
  say(__func__, 4, NUMBER(valid[3]), POINTER(scene), NUMBER(rays->tfar[0]), POINTER(options));
}
#else
void rtcIntersect1(RTCScene scene, struct RTCIntersectContext* context, struct RTCRayHit* ray) {
  say(__func__, 3, POINTER(scene), POINTER(context), NUMBER(ray->ray.tfar));
}

void rtcOccluded4(const int* valid, RTCScene scene, struct RTCIntersectContext* context,
                  struct RTCRay4* rays) {
  say(__func__, 4, NUMBER(valid[3]), POINTER(scene), POINTER(context), NUMBER(rays->tfar[0]));
}
#endif
#endif
