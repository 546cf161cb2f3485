/* Preloaded, it makes every Embree device use the instruction set that EMBREE_ISA names (sse2, sse4.2, avx,
 * avx2, avx512), whatever the program asks for besides: how much do Embree's own roundings change a picture,
 * and does all hold on a lesser processor? */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "stbvh/stbvh_embree.h"

/* Of an Embree that is in the global scope, or was loaded by a Python module for itself. */
static void* look_up(const char* name) {
  static const char* const kLibraries[] = {"libembree4.so.4", "libembree3.so.3"};
  void* found = dlsym(RTLD_NEXT, name);
  for (int i = 0; i < 2 && found == NULL; ++i) {
    void* const library = dlopen(kLibraries[i], RTLD_LAZY | RTLD_NOLOAD);
    if (library != NULL) found = dlsym(library, name);
  }
  return found;
}

__attribute__((visibility("default"))) RTCDevice rtcNewDevice(const char* config) {
  RTCDevice (*new_device)(const char*) = (RTCDevice(*)(const char*))(size_t)look_up("rtcNewDevice");
  const char* const isa = getenv("EMBREE_ISA");
  char own[1024];
  if (isa == NULL) return new_device(config);
  snprintf(own, sizeof(own), "%s,isa=%s", config == NULL ? "" : config, isa);
  return new_device(own);
}
