/* A triangle that moves in two segments, above a static one: built, attached, asked at five times. */
#include <math.h>
#include <stbvh/stbvh_embree.h>
#include <stdio.h>

static const float kFirst[9] = {-1, -1, 0, 1, -1, 0, 0, 1, 0}; /* at time 0   */
static const float kSecond[9] = {2, -1, 0, 4, -1, 0, 3, 1, 0}; /* at time 0.5 */
static const float kThird[9] = {2, 5, 0, 4, 5, 0, 3, 7, 0};    /* at time 1   */
static const float kGround[9] = {-9, -9, -1, 9, -9, -1, 0, 9, -1};
static const unsigned int kIndices[3] = {0, 1, 2};

static enum RTCError add_triangle(StbvhGeometry geometry, const void* const* steps, unsigned int step_count) {
  struct StbvhMeshArguments mesh;
  stbvhInitMeshArguments(&mesh);
  mesh.indices = kIndices;
  mesh.triangleCount = 1;
  mesh.vertices = steps;
  mesh.vertexCount = 3;
  mesh.stepCount = step_count;
  mesh.geomID = stbvhGetMeshCount(geometry); /* tell the meshes apart in hits */
  return stbvhAddMesh(geometry, &mesh, NULL);
}

static unsigned int trace(RTCScene scene, float x, float y, float time) {
  struct RTCRayHit query = {.ray = {x, y, 5, 0, 0, 0, -1, time, INFINITY, 0xFFFFFFFFu, 0, 0},
                            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &query, NULL);
#else
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    printf("time %.2f at (%g, %g): nothing\n", time, x, y);
  } else {
    printf("time %.2f at (%g, %g): mesh %u, distance %g\n", time, x, y, query.hit.geomID, query.ray.tfar);
  }
  return query.hit.geomID;
}

int main(void) {
  const void* const moving[3] = {kFirst, kSecond, kThird};
  const void* const ground[1] = {kGround};
  const RTCDevice device = rtcNewDevice(NULL);
  if (device == NULL) {
    fprintf(stderr, "no Embree device: error %d\n", (int)rtcGetDeviceError(NULL));
    return 1;
  }
  const RTCScene scene = rtcNewScene(device);
  const StbvhGeometry geometry = stbvhNewGeometry(device);
  if (geometry == NULL) {
    fprintf(stderr, "stbvh: %s\n", stbvhGetErrorMessage(NULL));
    return 1;
  }
  int failed = add_triangle(geometry, moving, 3) != RTC_ERROR_NONE ||
               add_triangle(geometry, ground, 1) != RTC_ERROR_NONE ||
               stbvhCommitGeometry(geometry) != RTC_ERROR_NONE;
  if (failed) fprintf(stderr, "stbvh: %s\n", stbvhGetErrorMessage(geometry));
  rtcAttachGeometry(scene, stbvhGetGeometry(geometry));
  rtcCommitScene(scene);
  /* The moving triangle is mesh 0 and lies nearer than the ground, mesh 1. */
  failed |= trace(scene, 0.0f, 0.0f, 0.00f) != 0;
  failed |= trace(scene, 0.0f, 0.0f, 0.50f) != 1;
  failed |= trace(scene, 1.5f, 0.0f, 0.25f) != 0;
  failed |= trace(scene, 3.0f, 3.0f, 0.75f) != 0;
  failed |= trace(scene, 3.0f, 6.0f, 1.00f) != 0;
  failed |= trace(scene, 30.f, 0.0f, 1.00f) != RTC_INVALID_GEOMETRY_ID;
  rtcReleaseScene(scene);
  stbvhReleaseGeometry(geometry);
  rtcReleaseDevice(device);
  return failed;
}
