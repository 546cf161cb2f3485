#include "ribbon.h"

void attach_with_embree(RTCDevice device, RTCScene scene, const struct Ribbon* ribbon) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, ribbon->triangles, 0,
                             sizeof ribbon->triangles[0], kTriangles);
  rtcSetGeometryTimeStepCount(geometry, kSteps);
  for (unsigned int step = 0; step < kSteps; ++step) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3,
                               ribbon->vertices[step], 0, sizeof ribbon->vertices[0][0], kVertices);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}
