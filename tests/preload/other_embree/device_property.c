/* Preloaded behind the preload library, it makes an Embree say that it was built with another option: of the
 * device property whose number EMBREE_PROPERTY holds, it gives EMBREE_VALUE. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>

#include "stbvh/stbvh_embree.h"

ssize_t rtcGetDeviceProperty(RTCDevice device, enum RTCDeviceProperty property) {
  typedef ssize_t (*Function)(RTCDevice, enum RTCDeviceProperty);
  const Function native = (Function)(size_t)dlsym(RTLD_NEXT, "rtcGetDeviceProperty");
  if ((int)property == atoi(getenv("EMBREE_PROPERTY"))) return atoi(getenv("EMBREE_VALUE"));
  return native(device, property);
}
