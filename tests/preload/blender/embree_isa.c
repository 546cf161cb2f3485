/* Preloaded, it makes every Embree device use the instruction set that EMBREE_ISA names, whatever the program
 * asks for: how much do Embree's own roundings change a picture? */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <stdio.h>
#include <stdlib.h>

__attribute__((visibility("default"))) RTCDevice rtcNewDevice(const char* config) {
  (void)config;
  RTCDevice (*new_device)(const char*) = (RTCDevice(*)(const char*))(size_t)dlsym(RTLD_NEXT, "rtcNewDevice");
  const char* const isa = getenv("EMBREE_ISA");
  char own[64];
  snprintf(own, sizeof(own), "isa=%s", isa == NULL ? "sse4.2" : isa);
  return new_device(own);
}
