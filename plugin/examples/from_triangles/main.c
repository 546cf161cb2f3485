/* A waving ribbon, once as Embree's own triangles and once through us: the same rays hit the same triangles.
 */
#include <math.h>
#include <stdio.h>

#include "ribbon.h"

/* Down from z = 5. */
static struct RTCRayHit trace(RTCScene scene, float x, float y, float time) {
  struct RTCRayHit query = {.ray = {x, y, 5, 0, 0, 0, -1, time, INFINITY, 0xFFFFFFFFu, 0, 0},
                            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &query, NULL);
#else
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
  return query;
}

static void print_hit(const struct RTCRayHit* query) {
  if (query->hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    printf("  %-34s", "nothing");
  } else {
    printf("  triangle %3u, distance %.5f   ", query->hit.primID, (double)query->ray.tfar);
  }
}

static int same_hit(const struct RTCRayHit* a, const struct RTCRayHit* b) {
  if (a->hit.geomID != b->hit.geomID) return 0;
  if (a->hit.geomID == RTC_INVALID_GEOMETRY_ID) return 1;
  return a->hit.primID == b->hit.primID && fabsf(a->ray.tfar - b->ray.tfar) <= 1e-5f * a->ray.tfar &&
         fabsf(a->hit.u - b->hit.u) <= 1e-4f && fabsf(a->hit.v - b->hit.v) <= 1e-4f;
}

/* How many rays hit something, and how many of all differ between the two. */
static void compare(RTCScene native, RTCScene ours, int* hits, int* differences) {
  printf("%17s  %-34s  %s\n", "", "Embree", "STBVH");
  for (int i = 0; i < 20; ++i) {
    const float x = 0.31f + 0.55f * (float)i, y = i % 2 == 0 ? 0.37f : -0.41f,
                time = (float)(i * 7 % 20) / 19;
    const struct RTCRayHit a = trace(native, x, y, time), b = trace(ours, x, y, time);
    printf("x %5.2f  time %.2f", (double)x, (double)time);
    print_hit(&a);
    print_hit(&b);
    printf("%s\n", same_hit(&a, &b) ? "" : "DIFFERENT");
    *hits += a.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    *differences += !same_hit(&a, &b);
  }
}

int main(void) {
  static struct Ribbon ribbon;
  int hits = 0, differences = 0;
  const RTCDevice device = rtcNewDevice(NULL);
  const RTCScene native = rtcNewScene(device), ours = rtcNewScene(device);
  make_ribbon(&ribbon);
  attach_with_embree(device, native, &ribbon);
  attach_with_stbvh(device, ours, &ribbon);
  rtcCommitScene(native);
  rtcCommitScene(ours);
  compare(native, ours, &hits, &differences);
  rtcReleaseScene(native);
  rtcReleaseScene(ours);
  release_stbvh();
  rtcReleaseDevice(device);
  printf("%d of 20 rays hit, %d differ\n", hits, differences);
  return hits < 10 || differences > 0;
}
