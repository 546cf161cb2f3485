/* Preloaded behind the preload library, it makes an Embree 4 that lays out queries otherwise. As EMBREE_HIDES
 * says: options: it hands on a copy of them; instPrimID: it does not know the last member of a hit. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "stbvh/stbvh_embree.h"

void rtcIntersect1(RTCScene scene, struct RTCRayHit* ray, struct RTCIntersectArguments* options) {
  typedef void (*Function)(RTCScene, struct RTCRayHit*, struct RTCIntersectArguments*);
  const Function native = (Function)(size_t)dlsym(RTLD_NEXT, "rtcIntersect1");
  const char* const hidden = getenv("EMBREE_HIDES");
  struct RTCIntersectArguments copy;
  if (options != NULL && strcmp(hidden, "options") == 0) {
    copy = *options;
    options = &copy;
  }
  const unsigned before = ray->hit.instPrimID[0];
  native(scene, ray, options);
  if (strcmp(hidden, "instPrimID") == 0) ray->hit.instPrimID[0] = before;
}
