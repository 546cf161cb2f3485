/* Preloaded, it makes every Embree device use the instruction set that EMBREE_ISA names (sse2, sse4.2, avx,
 * avx2, avx512), whatever the program asks for besides: how much do Embree's own roundings change a picture,
 * and does all hold on a lesser processor? */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "stbvh/stbvh_embree.h"

__attribute__((visibility("default"))) RTCDevice rtcNewDevice(const char* config) {
  RTCDevice (*new_device)(const char*) = (RTCDevice(*)(const char*))(size_t)dlsym(RTLD_NEXT, "rtcNewDevice");
  const char* const isa = getenv("EMBREE_ISA");
  char own[1024];
  if (isa == NULL) return new_device(config);
  snprintf(own, sizeof(own), "%s,isa=%s", config == NULL ? "" : config, isa);
  return new_device(own);
}
