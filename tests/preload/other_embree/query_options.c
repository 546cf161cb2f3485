/* Preloaded behind the preload library, it makes an Embree 4 of which nobody can say where it keeps what a
 * query brings with it: it hands on a copy. */
#define _GNU_SOURCE
#include <dlfcn.h>

#include "stbvh/stbvh_embree.h"

void rtcIntersect1(RTCScene scene, struct RTCRayHit* ray, struct RTCIntersectArguments* options) {
  typedef void (*Function)(RTCScene, struct RTCRayHit*, struct RTCIntersectArguments*);
  const Function native = (Function)(size_t)dlsym(RTLD_NEXT, "rtcIntersect1");
  struct RTCIntersectArguments copy;
  if (options != NULL) copy = *options;
  native(scene, ray, options == NULL ? NULL : &copy);
}
