/// The device's functions that the application reaches here first.
#include <cstdio>
#include <new>

#include "plugin/preload/environment.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/statistics.h"
#include "plugin/preload/tracked_device.h"

using stbvh::preload::find_device;
using stbvh::preload::real;

namespace {

/// Other majors have the same names, but rays and callbacks of another kind. Embree 2 has no properties.
/// Silent where the library for that major stands before the same program.
bool is_our_major(RTCDevice device) {
  const auto property = real().rtcGetDeviceProperty;
  const auto major = property == nullptr ? 2 : property(device, RTC_DEVICE_PROPERTY_VERSION_MAJOR);
  if (major == RTC_VERSION_MAJOR) return true;
  if (!stbvh::preload::is_loaded_for(major)) {
    std::fprintf(stderr, "libstbvh_preload: this is for Embree %d; everything is left to this Embree %d\n",
                 RTC_VERSION_MAJOR, static_cast<int>(major));
  }
  return false;
}

}  // namespace

extern "C" {

RTCDevice rtcNewDevice(const char* config) {
  const RTCDevice device = real().rtcNewDevice(config);
  if (device == nullptr) return device;
  try {
    if (!stbvh::preload::environment().enabled || !is_our_major(device)) return device;
    stbvh::preload::track_device(device, config);
    stbvh::preload::report_statistics_at_exit();
    stbvh::preload::count_device();
  } catch (const std::bad_alloc&) {
    std::fputs("libstbvh_preload: out of memory; everything is left to Embree\n", stderr);
  }
  return device;
}

RTCError rtcGetDeviceError(RTCDevice device) {
  const RTCError own = stbvh::preload::take_pending_error(device);
  return own != RTC_ERROR_NONE ? own : real().rtcGetDeviceError(device);
}

void rtcSetDeviceErrorFunction(RTCDevice device, RTCErrorFunction function, void* user_ptr) {
  const auto tracked = find_device(device);
  if (tracked == nullptr) return real().rtcSetDeviceErrorFunction(device, function, user_ptr);
  tracked->set_error_function(function, user_ptr);
}

void rtcSetDeviceMemoryMonitorFunction(RTCDevice device, RTCMemoryMonitorFunction function, void* user_ptr) {
  real().rtcSetDeviceMemoryMonitorFunction(device, function, user_ptr);
  if (const auto tracked = find_device(device)) tracked->set_memory_monitor(function, user_ptr);
}

}  // extern "C"
