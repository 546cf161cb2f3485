/// Setting the error of an Embree device, as Embree's own functions do when they fail.
#pragma once

#include "plugin/embree_api.h"

namespace stbvh::plugin {

/// Makes `code` what rtcGetDeviceError(device) returns on this thread, if it has no older error to return,
/// and calls the device's error function. With a null device it is the thread's error.
///
/// Embree 3 has no function for that, so one is called that fails with this very code, and does nothing else.
/// Without the memory for it the error stays unset.
void set_device_error(RTCDevice device, RTCError code) noexcept;

}  // namespace stbvh::plugin
