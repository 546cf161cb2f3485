/// What Embree makes of packets on this processor.
#pragma once

#include "stbvh/stbvh_embree.h"

namespace stbvh::test {

/// Whether Embree traces packets of N as such.
template <unsigned N>
bool is_native_width(RTCDevice device) {
  constexpr RTCDeviceProperty kProperty = N == 4   ? RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED
                                          : N == 8 ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                   : RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED;
  return rtcGetDeviceProperty(device, kProperty) != 0;
}

/// Whether lanes of a packet of N are switched off by `valid`. Embree 3 cuts up packets that it does not
/// trace as such, as it does streams, and takes only tnear > tfar for switched off.
template <unsigned N>
bool looks_at_valid(RTCDevice device) {
  return RTC_VERSION_MAJOR >= 4 || is_native_width<N>(device);
}

}  // namespace stbvh::test
