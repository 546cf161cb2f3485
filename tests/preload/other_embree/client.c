/* Calls what a program calls that renders moving triangles, for other_embree_test.py, and says what it is
 * answered. */
#include <stdint.h>
#include <stdio.h>

#include "stbvh/stbvh_embree.h"

#if EMBREE_MAJOR > 2
static void on_error(void* user, enum RTCError code, const char* message) {
  (void)user, (void)code, (void)message;
}

static bool on_memory(void* user, ssize_t bytes, bool post) {
  (void)user, (void)bytes, (void)post;
  return true;
}

static bool on_progress(void* user, double fraction) {
  (void)user, (void)fraction;
  return true;
}

static void filter(const struct RTCFilterFunctionNArguments* arguments) {
  (void)arguments;
}

static RTCGeometry new_triangle(RTCDevice device) {
  static float vertices[2][12] = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 1, 0, 1, 0, 1, 1}};
  static unsigned indices[3] = {0, 1, 2};
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryTimeStepCount(geometry, 2);
  rtcSetGeometryTimeRange(geometry, 0.25f, 0.75f);
  rtcSetGeometryMask(geometry, 5);
  rtcSetGeometryUserData(geometry, (void*)(uintptr_t)42);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12, 1);
  for (unsigned step = 0; step < 2; ++step) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, vertices[step], 0,
                               12, 3);
  }
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcSetGeometryOccludedFilterFunction(geometry, filter);
  rtcCommitGeometry(geometry);
  return geometry;
}

static RTCGeometry new_instance(RTCDevice device, RTCScene scene) {
  static const float matrix[12] = {2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0};
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, scene);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
  rtcCommitGeometry(geometry);
  return geometry;
}

static void use(RTCDevice device) {
  rtcSetDeviceErrorFunction(device, on_error, device);
  rtcSetDeviceMemoryMonitorFunction(device, on_memory, device);
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  rtcSetSceneProgressMonitorFunction(scene, on_progress, scene);
  const RTCGeometry triangle = new_triangle(device);
  printf("attached as %u\n", rtcAttachGeometry(scene, triangle));
  rtcRetainGeometry(triangle);
  rtcReleaseGeometry(triangle);
  rtcJoinCommitScene(scene);
  rtcDisableGeometry(triangle);
  rtcEnableGeometry(triangle);
  rtcUpdateGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 1);
  rtcCommitGeometry(triangle);
  rtcAttachGeometryByID(scene, new_instance(device, scene), 9);
  rtcCommitScene(scene);
  struct RTCPointQuery query = {.x = 3};
  struct RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  printf("point query: %d\n", rtcPointQuery(scene, &query, &context, NULL, scene));
  struct RTCRayHit ray = {.ray = {.tfar = 5}};
  struct RTCRay4 rays = {.tfar = {6}};
  const int valid[4] = {-1, -1, -1, -1};
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &ray, NULL);
  rtcOccluded4(valid, scene, &rays, NULL);
#else
  rtcIntersect1(scene, NULL, &ray);
  rtcOccluded4(valid, scene, NULL, &rays);
#endif
  printf("error: %d\n", (int)rtcGetDeviceError(device));
  rtcDetachGeometry(scene, 77);
  rtcRetainScene(scene);
  rtcReleaseScene(scene);
}
#endif

__attribute__((visibility("default"))) void run(void);  // called by ctypes

void run(void) {
  const RTCDevice device = rtcNewDevice("threads=1");
  printf("device: %ju\n", (uintmax_t)(uintptr_t)device);
#if EMBREE_MAJOR > 2
  use(device);
#endif
  fflush(stdout);
}
