/* Embree 4: a query that brings an intersection function of its own, for a disc of the application's, and
 * hits a triangle of ours all the same. */
#include <math.h>
#include <stbvh/stbvh_embree.h>
#include <stdio.h>

enum { kDisc = 0, kMesh = 1 };

static const float kFirst[9] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
static const float kSecond[9] = {3, -1, 0, 5, -1, 0, 4, 1, 0};
static const unsigned int kIndices[3] = {0, 1, 2};

static void disc_bounds(const struct RTCBoundsFunctionArguments* args) {
  const struct RTCBounds bounds = {
      .lower_x = -2, .lower_y = -2, .lower_z = -1, .upper_x = 2, .upper_y = 2, .upper_z = -1};
  *args->bounds_o = bounds;
}

/* A disc of radius 2 at z = -1; this program traces single rays only. */
static void intersect_disc(const struct RTCIntersectFunctionNArguments* args) {
  struct RTCRayHit* const query = (struct RTCRayHit*)args->rayhit;
  const float t = (-1 - query->ray.org_z) / query->ray.dir_z;
  const float x = query->ray.org_x + t * query->ray.dir_x, y = query->ray.org_y + t * query->ray.dir_y;
  if (!args->valid[0] || x * x + y * y > 4 || t <= query->ray.tnear || t > query->ray.tfar) return;
  query->ray.tfar = t;
  query->hit.Ng_x = query->hit.Ng_y = query->hit.u = query->hit.v = 0;
  query->hit.Ng_z = 1;
  query->hit.geomID = args->geomID;
  query->hit.primID = args->primID;
  query->hit.instID[0] = args->context->instID[0];
}

/* Embree calls this for every user geometry of the scene. */
static void intersect(const struct RTCIntersectFunctionNArguments* args) {
  if (args->geomID == kMesh) {
    stbvhIntersectFunctionN(args);
  } else {
    intersect_disc(args);
  }
}

static unsigned int trace(RTCScene scene, float time) {
  struct RTCRayHit query = {.ray = {0, 0, 5, 0, 0, 0, -1, time, INFINITY, 0xFFFFFFFFu, 0, 0},
                            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
  struct RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.intersect = intersect;
  rtcIntersect1(scene, &query, &arguments);
  printf("time %.2f: %s, distance %g\n", time, query.hit.geomID == kMesh ? "triangle" : "disc",
         query.ray.tfar);
  return query.hit.geomID;
}

int main(void) {
  const void* const steps[2] = {kFirst, kSecond};
  const RTCDevice device = rtcNewDevice(NULL);
  const RTCScene scene = rtcNewScene(device);
  const RTCGeometry disc = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  const StbvhGeometry geometry = stbvhNewGeometry(device);
  struct StbvhMeshArguments mesh;
  stbvhInitMeshArguments(&mesh);
  mesh.indices = kIndices;
  mesh.triangleCount = 1;
  mesh.vertices = steps;
  mesh.vertexCount = 3;
  mesh.stepCount = 2;
  int failed = stbvhAddMesh(geometry, &mesh, NULL) != RTC_ERROR_NONE ||
               stbvhCommitGeometry(geometry) != RTC_ERROR_NONE;
  if (failed) fprintf(stderr, "stbvh: %s\n", stbvhGetErrorMessage(geometry));
  rtcSetGeometryUserPrimitiveCount(disc, 1);
  rtcSetGeometryBoundsFunction(disc, disc_bounds, NULL);
  rtcCommitGeometry(disc);
  rtcAttachGeometryByID(scene, disc, kDisc);
  rtcAttachGeometryByID(scene, stbvhGetGeometry(geometry), kMesh);
  rtcReleaseGeometry(disc);
  rtcCommitScene(scene);
  failed |= trace(scene, 0.0f) != kMesh;
  failed |= trace(scene, 0.5f) != kDisc;
  rtcReleaseScene(scene);
  stbvhReleaseGeometry(geometry);
  rtcReleaseDevice(device);
  return failed;
}
